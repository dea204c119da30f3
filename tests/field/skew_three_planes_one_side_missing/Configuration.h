  #define XY_DIAG_AC 140.70
  #define XY_DIAG_BD 142.20
  #define XY_SIDE_AD 99.96

  #define SKEW_CORRECTION_FOR_Z
  #if ENABLED(SKEW_CORRECTION_FOR_Z)
    #define XZ_DIAG_AC 141.91
    #define XZ_DIAG_BD 142.06
    #define YZ_DIAG_AC 141.65
    #define YZ_DIAG_BD 142.75
    #define YZ_SIDE_AD 100.5
  #endif
