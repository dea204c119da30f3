#if ENABLED(SKEW_CORRECTION)
  // Input all length measurements here:
  #define XY_DIAG_AC 141,1
  #define XY_DIAG_BD 141.6
  #define XY_SIDE_AD 100.6

  // Or, set the default skew factors directly here
  // to override the above measurements:
  #define XY_SKEW_FACTOR 0.0
#endif
