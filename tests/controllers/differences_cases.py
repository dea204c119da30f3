"""What differences.py compares: the lines of each case, and why the two differ where they do."""

import dataclasses


@dataclasses.dataclass(frozen=True)
class Case:
    line: str                    # Lines of one case: one behind another, `;;` between.
    why: str = ""                # Why they differ, for the table.
    twin: str = ""               # What the emulation is told in its place.
    before: tuple = None         # In place of the group's: as it was switched on, ().
    twin_before: tuple = None
    program: bool = False        # LinuxCNC: a .ngc file.

    def real_lines(self):
        return [line.strip() for line in self.line.split(";;")]

    def emulated_lines(self):
        return [line.strip() for line in (self.twin or self.line).split(";;")]

    def before_real(self, group):
        return group.before if self.before is None else self.before

    def before_emulated(self, group):
        other = self.before if self.twin_before is None else self.twin_before
        return group.twin_before if other is None else other

    def is_homed(self):
        return self.before is None

    def shown(self):
        both = self.line.replace(";;", "⏎") + (f" / {self.twin.replace(';;', '⏎')}" if self.twin else "")
        return ("as switched on: " if self.before == () else "") + both


@dataclasses.dataclass(frozen=True)
class Group:
    title: str
    machine: str
    real: str                    # klipper, linuxcnc
    emulated: str                # rrf, marlin, klipper
    truth: str
    before: tuple                # What both hear first.
    twin_before: tuple
    cases: tuple

    @property
    def same_dialect(self):
        return self.real == self.emulated

    @property
    def real_name(self):
        return "Klipper's host" if self.real == "klipper" else "LinuxCNC"


def numbered(number, line):
    sum_ = 0
    for byte in f"N{number} {line}".encode():
        sum_ ^= byte
    return f"N{number} {line}*{sum_}"


OFF = ()                         # As it was switched on.
# Why they differ. Those that begin with DEFECT ought to be mended in the emulation.
HOP = "the host homes at [safe_z_home] and hops to 12; the emulation stays over the middle, 10 over the switch"
BACK_OFF = "Kalico ends 5 mm off each switch, the emulation on it"
FLAT = "the station's emulation has one axis: X and Y are always there"
WORDS = "one refusal, other words"
REMARK = "the emulation passes over words that it does not read; Klipper's remarks begin with ;"
ON_WIRE = "DEFECT: the wire counts lines as Marlin does, whatever the dialect"
ELSEWHERE = "DEFECT: not known, and the move behind it goes elsewhere"
NOT_KNOWN = "not in the emulation; the next line is then another one"
FEED = "DEFECT: the emulation reads no F"
STRICTER = "stricter than Klipper, which reads Xabc as a word of its own"
POSITION = "documented as missing: lines mcu: and stepper:"
UNHOMED = "one refusal, other words"
OFFSET_XY = "refused: no offsets in X and Y here"
RESTS = "the real one tells each touch; both end on the trigger"
SPEED = "DEFECT: PROBE's own words are passed over in silence"
ACCURACY = "each touch is told, and a delta more; the figures agree"
SITE = "printer.cfg says where, and 5 mm, 4 mm/s; the emulation stays where it is"
CALIBRATE = ("other words, of which `caltwin calibrate` reads both; the offset agrees. "
             "It ends over the bed, the emulation at the dock")
MESH = "printer.cfg has no [bed_mesh]"
REACH = "DEFECT: a delta's emulation knows no lowest Z"
STEP = "one step of all towers: Klipper stops in the step behind the trigger, the emulation rounds"
SAVES = "DELTA_CALIBRATE is in force after SAVE_CONFIG, G33 at once"
G92 = "RepRapFirmware moves the machine's zero, Klipper and LinuxCNC shift the work"
INCHES = "refused: no inches here"
NAMES = "commands of several letters are no G-code to RepRapFirmware"
MEAN = "Klipper levels to [probe] z_offset (-0.02), G30 S to where the probe acts"
G28_GOES = "LinuxCNC's G28 goes to a stored place, from the start 0 0 0, in rapid; RepRapFirmware's homes"
G28_WORD = "LinuxCNC wants a number, RepRapFirmware the bare letter"
BLANKS = "LinuxCNC takes blanks away first"
NO_FEED = "LinuxCNC wants F before the first G1; RepRapFirmware has one from the start"
STRICT = "LinuxCNC is stricter"
NO_MOVE = "DEFECT: words behind G53, G90 and G54 without G0 or G1 are lost in silence"
P_WANTED = "LinuxCNC wants P; RepRapFirmware takes the one in force"
ARC = "refused: no arcs here"
TOOL_OFFSET = "DEFECT: a warning alone, and later moves go elsewhere; no tool offsets here"
LANGUAGE = "another language: # and [] are LinuxCNC's, {} RepRapFirmware's"
CYCLE = "DEFECT: a warning alone, and no hole is drilled"
M_CODES = "a printer's M code"
TRAVEL = "the INI file is written with 5 mm under the drawing's Z, the emulation keeps to the drawing"
OVERSHOOT = "LinuxCNC slows down behind the trigger: #5063 is the place, not where it stands"
PROBE_FEED = "LinuxCNC wants F; RepRapFirmware has a speed of its own"
PARAMETER = "RepRapFirmware has no #5063: M114 or move.axes[].userPosition"
ENDS = "M2 is not known, with a warning; lines on a wire have no end"
G_UNKNOWN = "LinuxCNC refuses, the emulation warns and goes on"
MODELESS = "only LinuxCNC and the gantry's emulation know it"
OVER_BED = ("G28", "G1 X117.5 Y100 F6000", "G1 Z15 F600")
STATION = Group(
    "A printer's Z station: Klipper against Klipper's dialect", "z_station", "klipper", "klipper",
    "{switch_offset: {off_um: 80}}", OVER_BED, (*OVER_BED, "ATTACH_PROBE", "G1 X117.5 Y100 F6000", "G1 Z15 F600"),
    (
        Case("G28", HOP, before=OFF),
        Case("G28 X", FLAT, before=OFF),
        Case("G28 Z", FLAT, before=OFF),
        Case("G1 Z20 F600", WORDS, before=OFF),
        Case("G28 X Y ;; G1 X50 F3000", FLAT, before=OFF),
        Case("G1 Z20 F600"),
        Case("g1 z20 f600"),
        Case("G1X50Y50F3000", "DEFECT: words without blanks are one word to the emulation"),
        Case("G0 X50 (to the left) Y60", REMARK),
        Case("G1 X50 ; to the left"),
        Case("; a remark alone"),
        Case(numbered(3, "G1 X50"), ON_WIRE),
        Case("N3 G1 X50*1", ON_WIRE),
        Case("G90 G1 X50"),
        Case("G1 X500", WORDS),
        Case("G1 Z-6", WORDS),
        Case("G1 X50 F0", FEED),
        Case("G1 X50 F-100", FEED),
        Case("G1 Xabc", STRICTER),
        Case("G1 X", WORDS),
        Case("G1 Z20 Z30"),
        Case("G91 ;; G1 X5", ELSEWHERE),
        Case("G92 X0 ;; G1 X5", ELSEWHERE),
        Case("G20", WORDS),
        Case("G21"),
        Case("G4 P100"),
        Case("G2 X50 Y50 I10 J0"),
        Case("G29"),
        Case("M18 ;; G1 X50", NOT_KNOWN),
        Case("M82"),
        Case("M105"),
        Case("M112", "DEFECT: not in the emulation: it goes on"),
        Case("M114"),
        Case("M115"),
        Case("M117 hello"),
        Case("M118 hello"),
        Case("M400"),
        Case("T0"),
        Case("FROBNICATE"),
        Case("GET_POSITION", POSITION),
        Case("STATUS"),
        Case("QUERY_PROBE"),
        Case("QUERY_ENDSTOPS"),
        Case("SAVE_GCODE_STATE NAME=a ;; G1 X50 ;; RESTORE_GCODE_STATE NAME=a MOVE=1", ELSEWHERE),
        Case("SET_GCODE_VARIABLE MACRO=m VARIABLE=v VALUE=1"),
        Case("SET_KINEMATIC_POSITION Z=20"),
        Case("SET_GCODE_OFFSET Z=0.1 ;; GET_POSITION", POSITION),
        Case("SET_GCODE_OFFSET Z=0.1 ;; G1 Z10 F600"),
        Case("SET_GCODE_OFFSET Z_ADJUST=0.1 MOVE=1"),
        Case("SET_GCODE_OFFSET Z=0.1 MOVE=1", UNHOMED, before=OFF),
        Case("SET_GCODE_OFFSET X=1 ;; G1 X50", OFFSET_XY),
        Case("SET_GCODE_OFFSET Z=abc"),
        Case("PROBE", RESTS),
        Case("PROBE", WORDS, before=OFF),
        Case("PROBE SAMPLES=5 SAMPLES_RESULT=median", RESTS),
        Case("PROBE PROBE_SPEED=-1", SPEED),
        Case("PROBE_ACCURACY", ACCURACY),
        Case("PROBE_ACCURACY SAMPLES=3", ACCURACY),
        Case("PROBE_ACCURACY SAMPLES=0", WORDS),
        Case("G1 X20 Y150 ;; PROBE", RESTS),
        Case("PROBE ;; PROBE", RESTS),
        Case("PROBE ;; PROBE_ACCURACY", RESTS),
        Case("PROBE ;; G1 Z15 ;; PROBE", RESTS),
        Case("PROBE_CALIBRATE"),
        Case("PROBE_Z_ACCURACY", SITE),
        Case("CALIBRATE_Z", CALIBRATE, before=OFF),
        Case("CALIBRATE_Z", CALIBRATE),
        Case("CALIBRATE_Z ;; GET_POSITION", CALIBRATE),
        Case("CALIBRATE_Z ;; CALIBRATE_Z", CALIBRATE),
        Case("SET_GCODE_OFFSET Z=0.3 ;; CALIBRATE_Z", CALIBRATE),
        Case("BED_MESH_CALIBRATE"),
        Case("BED_MESH_CLEAR", MESH),
        Case("SAVE_CONFIG"),
        Case("FIRMWARE_RESTART ;; G1 Z20", NOT_KNOWN),
    ))

DELTA = Group(
    "A delta: Klipper against Marlin's dialect", "delta_printer", "klipper", "marlin",
    "{endstop.a: {error_mm: 0.3}, delta_radius: {error_mm: 0.8}}",
    ("G28", "G1 X0 Y0 Z20 F6000"), ("G28", "G1 X0 Y0 Z20 F6000"),
    (
        Case("G28", BACK_OFF, before=OFF),
        Case("G28 X", BACK_OFF, before=OFF),
        Case("G1 X5", before=OFF),
        Case("G1 X30 Y20 F6000"),
        Case("g1 x30 y20"),
        Case("G1X30Y20F6000"),
        Case("G1 X30 (right) Y20", "the emulation takes remarks in brackets, Klipper none"),
        Case("G1 X30 F0", FEED),
        Case("G1 X300"),
        Case("G1 Z-40", REACH),
        Case("G1 Z320", REACH),
        Case("G91 ;; G1 X5 Z-5", ELSEWHERE),
        Case("G92 X10 ;; G1 X15", ELSEWHERE),
        Case("G20 ;; G1 X1", INCHES),
        Case("G4 P10"),
        Case("G2 X10 Y0 I5 J0", ARC),
        Case("G29"),
        Case("M84 ;; G1 X5", NOT_KNOWN),
        Case("M112", "DEFECT: not in the emulation: it goes on"),
        Case("M114"),
        Case("M117 hello"),
        Case("M400"),
        Case("FROBNICATE"),
        Case("PROBE", STEP, twin="G30"),
        Case("G1 X60 Y-30 ;; PROBE", twin="G30 X60 Y-30"),
        Case("PROBE", twin="G30", before=OFF),
        Case("DELTA_CALIBRATE ;; G28 ;; G1 X0 Y0 Z20 F6000 ;; PROBE", SAVES, twin="G33 P2 ;; G28 ;; G30 X0 Y0"),
        Case("DELTA_CALIBRATE ;; SAVE_CONFIG ;; G28 ;; G1 X0 Y0 Z20 F6000 ;; PROBE",
             "both within a step of 12.5 um", twin="G33 P2 ;; M500 ;; G28 ;; G30 X0 Y0"),
        Case("DELTA_CALIBRATE ;; G28 ;; G1 X60 Y-30 Z20 F6000 ;; PROBE", SAVES, twin="G33 P2 ;; G28 ;; G30 X60 Y-30"),
    ))

SCREWS = Group(
    "A bed on three screws: Klipper against RepRapFirmware's dialect", "triple_z_printer", "klipper", "rrf",
    "{bed_tilt: {slope_x_mrad: 2, slope_y_mrad: -1}}", ("G28", "G1 Z10 F600", "G1 X100 Y100 F6000"),
    ("G28", "G1 Z10 F600", "G1 X100 Y100 F6000"),
    (
        Case("G28", BACK_OFF, before=OFF),
        Case("G1 X5", before=OFF),
        Case("G28 X Y", BACK_OFF, before=OFF),
        Case("G1 X50 Y60 F6000"),
        Case("G91 ;; G1 X5"),
        Case("G1 X500"),
        Case("G92 X10 ;; G1 X15", G92),
        Case("G20 ;; G1 X1", INCHES),
        Case("M84 ;; G1 X5"),
        Case("M112"),
        Case("FROBNICATE", NAMES),
        Case("G29"),
        Case("G32"),
        Case("PROBE", twin="G30 S-1"),
        Case("G1 X30 Y30 ;; PROBE", twin="G1 X30 Y30 ;; G30 S-1"),
        Case("Z_TILT_ADJUST ;; G1 X200 Y30 ;; PROBE", MEAN,
             twin="M671 X20:215:20 Y20:20:215 S10 ;; G30 P0 X20 Y20 Z-99999 ;; G30 P1 X215 Y20 Z-99999 ;;"
                  " G30 P2 X20 Y215 Z-99999 S3 ;; G1 X200 Y30 ;; G30 S-1"),
        Case("Z_TILT_ADJUST", before=OFF, twin="G30 P0 X20 Y20 Z-99999"),
    ))

ROUTER = Group(
    "A gantry: LinuxCNC against RepRapFirmware's dialect", "gantry_router", "linuxcnc", "rrf",
    "{backlash.z: {gap_mm: 0.1}}", ("G0 X100 Y100", "G0 Z20"), ("G28", "G0 X100 Y100", "G0 Z20"),
    (
        Case("G28", G28_GOES),
        Case("G28 X", G28_WORD),
        Case("G28 X10"),
        Case("G0 X50", before=OFF),
        Case("G38.2 Z-5 F60", TRAVEL, before=OFF),
        Case("G0 X50 Y60"),
        Case("g0x50y60"),
        Case("G0 X 5 0 Y60", BLANKS),
        Case("G1 X50", NO_FEED),
        Case("G1 X50 F600"),
        Case("G1 X50 F0"),
        Case("G1 X50 F-100"),
        Case("G0 X50 ;; Y60"),
        Case("G1 F600 ;; X50"),
        Case("G0 X50 (left) Y60 ; a remark"),
        Case("N10 G0 X50", ON_WIRE),
        Case(numbered(3, "G0 X50")),
        Case("G0 X500"),
        Case("G0 Z-6"),
        Case("G0 X"),
        Case("G0 X50 X60", STRICT),
        Case("G0 G1 X50 F600", STRICT),
        Case("G90 G0 X50"),
        Case("G91 G0 X5"),
        Case("G91 ;; G0 X5 ;; G90 ;; G0 Y50"),
        Case("G53 G0 X50"),
        Case("G53 X50", NO_MOVE),
        Case("G90 X50", NO_MOVE),
        Case("G54 X50", NO_MOVE),
        Case("G10 L2 P1 X10 ;; G0 X50"),
        Case("G10 L20 P1 X0 ;; G0 X5"),
        Case("G10 L2 P2 X10 ;; G55 ;; G0 X50"),
        Case("G10 L2 X10 ;; G0 X50", P_WANTED),
        Case("G59.3 G0 X50"),
        Case("G92 X0 ;; G0 X5", G92),
        Case("G92 X0 ;; G92.1 ;; G0 X50", G92),
        Case("G92 X0 ;; G53 G0 X50"),
        Case("G20 ;; G0 X1", INCHES),
        Case("G2 X120 Y100 I10 J0 F600", ARC),
        Case("G18"),
        Case("G4 P0.1 ;; G0 X50"),
        Case("G43 H1"),
        Case("G43.1 Z5 ;; G0 Z20", TOOL_OFFSET),
        Case("G54 G17 G40 G49 G80 G94 ;; G0 X50"),
        Case("G64 P0.01"),
        Case("G81 X50 Y50 Z10 R20 F600", CYCLE),
        Case("#1=50 ;; G0 X#1", LANGUAGE),
        Case("#<_left>=50 ;; G0 X#<_left>", LANGUAGE),
        Case("G0 X[40+10]", LANGUAGE),
        Case("G0 X{40+10}", LANGUAGE),
        Case("M3 S1000"),
        Case("M0"),
        Case("M6 T1"),
        Case("T1", "no tools in the emulation but the probe, T0"),
        Case("M400", M_CODES),
        Case("M114", M_CODES),
        Case("M112", M_CODES),
        Case("M2"),
        Case("M999", M_CODES),
        Case("G200", G_UNKNOWN),
        Case("FROBNICATE"),
        Case("%"),
        Case("G38.2 Z-5 F60", TRAVEL),
        Case("G38.2 Z0 F60", OVERSHOOT),
        Case("G38.2 Z0 F600", OVERSHOOT),
        Case("G38.2 Z0", PROBE_FEED),
        Case("G38.2 Z10 F60"),
        Case("G38.3 Z10 F60"),
        Case("G38.3 Z0 F60", OVERSHOOT),
        Case("G38.4 Z20 F60"),
        Case("G38.2 Z0 F60 ;; G38.4 Z10 F60", OVERSHOOT),
        Case("G38.2 Z0 F60 ;; G38.5 Z10 F60", OVERSHOOT),
        Case("G38.2 Z0 F60 ;; G38.2 Z0 F60"),
        Case("G38.2 F60"),
        Case("G38.2 X100 Y100 Z20 F60"),
        Case("G38.6 Z0 F60", G_UNKNOWN),
        Case("G38.2 Z0 F60 ;; G10 L20 P1 Z0 ;; G0 Z5", OVERSHOOT),
        Case("G38.2 Z0 F60 ;; G92 Z0 ;; G0 Z5", OVERSHOOT),
        Case("G38.2 Z0 F60 ;; G10 L2 P1 Z#5063 ;; G0 Z5", PARAMETER),
        Case("o100 repeat [3] ;; G91 G0 X5 ;; o100 endrepeat ;; G90 ;; M2", LANGUAGE, program=True),
        Case("G21 G90 G17 ;; G0 X50 Y50 ;; G1 X60 F600 ;; M2", "M2 is not known, with a warning", program=True),
        Case("G10 L2 P1 X10 ;; G54 ;; G0 X50 ;; M2 ;; G0 X60", ENDS, program=True),
        Case("G0 X50 ;; M30", "M30 is not known, with a warning", program=True),
    ))

MESH = Group(
    "A gantry: Klipper against RepRapFirmware's dialect", "gantry_router", "klipper", "rrf",
    "{backlash.z: {gap_mm: 0.1}}", ("G28", "G1 X100 Y100 F6000", "G1 Z20 F600"),
    ("G28", "G1 X100 Y100 F6000", "G1 Z20 F600"),
    (
        Case("G28", BACK_OFF, before=OFF),
        Case("G1 X50", before=OFF),
        Case("G1 X50 Y60 F3000"),
        Case("G1 X500"),
        Case("G92 X0 ;; G1 X5", G92),
        Case("G20 ;; G1 X1", INCHES),
        Case("G53 G1 X50", MODELESS),
        Case("G10 L2 P1 X10", MODELESS),
        Case("G38.2 Z-5 F60", MODELESS),
        Case("G2 X120 Y100 I10 J0 F600"),
        Case("PROBE", twin="G30 S-1"),
        Case("PROBE_ACCURACY", twin="G30 S-1"),
        Case("G29"),
        Case("BED_MESH_CALIBRATE", NAMES),
        Case("M84 ;; G1 X50"),
    ))

COREXY = Group(
    "A CoreXY: Klipper against RepRapFirmware's dialect", "corexy_printer", "klipper", "rrf",
    "{backlash.z: {gap_mm: 0.1}}", ("G28", "G1 X100 Y100 F6000", "G1 Z20 F600"),
    ("G28", "G1 X100 Y100 F6000", "G1 Z20 F600"),
    (
        Case("G28", BACK_OFF, before=OFF),
        Case("G1 X50 Y60 F3000"),
        Case("G1 X500"),
        Case("G92 X0 ;; G1 X5", G92),
        Case("PROBE", twin="G30 S-1"),
    ))

GROUPS = (STATION, DELTA, SCREWS, ROUTER, MESH, COREXY)
