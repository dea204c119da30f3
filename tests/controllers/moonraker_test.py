"""Klipper's web pages reach the twin through Moonraker: moonraker_test.py CALTWIN HOST MOONRAKER

caltwin, the host and Moonraker run in real time, all three as they are shipped. The test does over HTTP
and the websocket what Mainsail, Fluidd, KlipperScreen and Obico do when they connect, then homes, prints a
file, calibrates, saves, stops and starts again. Without host or Moonraker: skipped.
"""

import shutil
import signal
import socket
import sys
import tempfile
import time
from pathlib import Path

from klipper_delta_test import TRUTH, compare, machine_of, saved_by
from klipper_host import SKIPPED, HostError, Rig
from moonraker_page import Page, Refused, call, wait_until_ready

# As docs/klipper.md has them, with places and port of the test's own.
MOONRAKER_CONF = """[server]
host: 127.0.0.1
port: {port}
klippy_uds_address: {folder}/api

[authorization]
trusted_clients: 127.0.0.1
cors_domains: http://127.0.0.1:8080

[machine]
provider: none
validate_service: False
validate_config: False

[announcements]
enable_moonlight: False

[octoprint_compat]
"""
FOR_PAGES = """
[virtual_sdcard]
path: {folder}/data/gcodes
[display_status]
[pause_resume]
[bed_mesh]
mesh_radius: 80
round_probe_count: 3
[temperature_sensor board]
sensor_type: Generic 3950
sensor_pin: SPARE0
min_temp: 0
max_temp: 200
"""
# A pin that leads nowhere reads half, which is the 4700 Ohm of Klipper's pull-up. With 100 kOhm at 25 deg
# and 1.77 kOhm at 150 deg that is 111 deg by the formula of two points; Klipper's has three.
TEMPERATURE_C, NEGLECTED_C = 111, 5
STOPPED = "Shutdown due to webhooks request"  # The host's words for a page's emergency stop.
# From less high than the 12 mm of printer.cfg: what is hidden raises the bed by less than 1 mm.
CALIBRATES = "DELTA_CALIBRATE HORIZONTAL_MOVE_Z=5"
PRINTED = "G28\nG1 X20 Y0 Z50 F9000\nG1 X-20\nM117 printed\n"
OBJECTS = ("toolhead gcode_move configfile webhooks print_stats idle_timeout display_status virtual_sdcard "
           "pause_resume bed_mesh probe motion_report exclude_object system_stats mcu").split()


def asks_as_pages_do(page, port, claim):
    """What Mainsail, Fluidd, KlipperScreen and Obico ask when they connect."""
    named = page.ask("server.connection.identify", client_name="caltwin", version="1", type="web", url="-")
    claim("identify", named["connection_id"] > 0, named)
    info = page.ask("server.info")
    claim("server.info", info["klippy_connected"] and info["klippy_state"] == "ready", info)
    claim("components", not info["failed_components"] and not info["missing_klippy_requirements"], info)
    info = page.ask("printer.info")
    claim("printer.info", info["state"] == "ready" and info["config_file"].endswith("printer.cfg"), info)
    objects = page.ask("printer.objects.list")["objects"]
    claim("objects.list", set(OBJECTS) <= set(objects), objects)
    status = page.ask("printer.objects.subscribe", objects=dict.fromkeys(objects))["status"]
    claim("objects.subscribe", set(OBJECTS) <= {name for name in status if status[name]}, status.keys())
    claim("objects.query", page.ask("printer.objects.query", objects={"webhooks": None})["status"]
          == {"webhooks": {"state": "ready", "state_message": "Printer is ready"}})
    claim("toolhead", status["toolhead"]["axis_maximum"][:3] == [100, 100, 300], status["toolhead"])
    settings = status["configfile"]["settings"]
    claim("configfile", settings["printer"]["kinematics"] == "delta" and "delta_calibrate" in settings)
    claim("print_stats", status["print_stats"]["state"] == "standby", status["print_stats"])
    claim("idle_timeout", status["idle_timeout"]["state"] in ("Idle", "Ready"), status["idle_timeout"])
    claim("mcu", status["mcu"]["mcu_version"].startswith("caltwin"), status["mcu"])
    claim("gcode.help", "DELTA_CALIBRATE" in page.ask("printer.gcode.help"))
    ends = page.ask("printer.query_endstops.status")
    claim("endstops", ends == {"a": "open", "b": "open", "c": "open"}, ends)
    # The host tells the temperature once a second, and Moonraker stores it once a second.
    until, told = time.monotonic() + 10, 0
    while told < TEMPERATURE_C - NEGLECTED_C and time.monotonic() < until:
        told = page.ask("server.temperature_store")["temperature_sensor board"]["temperatures"][-1]
        time.sleep(0.2)
    claim("temperature_store", abs(told - TEMPERATURE_C) < NEGLECTED_C, told)
    claim("system_info", page.ask("machine.system_info")["system_info"]["cpu_info"]["cpu_count"] > 0)
    claim("proc_stats", "moonraker_stats" in page.ask("machine.proc_stats"))
    claim("server.config", page.ask("server.config")["config"]["server"]["port"] == port)
    names = {root["name"] for root in page.ask("server.files.roots")}
    claim("files.roots", {"config", "gcodes"} <= names, names)
    files = {file["path"] for file in page.ask("server.files.list", root="config")}
    claim("files.list", {"printer.cfg", "moonraker.conf"} <= files, files)
    claim("files.get_directory", "disk_usage" in page.ask("server.files.get_directory", path="gcodes"))
    page.ask("server.database.post_item", namespace="caltwin", key="page", value={"theme": 1})
    claim("database", page.ask("server.database.get_item", namespace="caltwin", key="page")["value"]
          == {"theme": 1} and "caltwin" in page.ask("server.database.list")["namespaces"])
    for method, key in (("server.webcams.list", "webcams"), ("server.announcements.list", "entries"),
                        ("server.job_queue.status", "queued_jobs"), ("server.history.list", "jobs")):
        claim(method, page.ask(method)[key] == [])


def prints(page, port, claim):
    """Uploads a file as a slicer does and has it printed."""
    edge, name = "edge-of-caltwin", "line.gcode"
    body = (f'--{edge}\r\nContent-Disposition: form-data; name="file"; filename="{name}"\r\n\r\n{PRINTED}\r\n'
            f'--{edge}\r\nContent-Disposition: form-data; name="print"\r\n\r\ntrue\r\n--{edge}--\r\n')
    status, _, answer = call(port, "POST", "/api/files/local", body,
                             {"Content-Type": f"multipart/form-data; boundary={edge}"})
    claim("upload", status in (200, 201), answer)

    def wait_until(state):
        page.wait("notify_status_update", 30,
                  lambda params: params[0].get("print_stats", {}).get("state") == state)

    wait_until("printing")
    page.ask("printer.print.pause")
    wait_until("paused")
    page.ask("printer.print.resume")
    wait_until("complete")
    claim("printed", page.ask("printer.objects.query", objects={"display_status": None})
          ["status"]["display_status"]["message"] == "printed")
    claim("files.list of gcodes", [file["path"] for file in page.ask("server.files.list")] == [name])
    claim("files.metadata", page.ask("server.files.metadata", filename=name)["size"] == len(PRINTED))
    jobs = page.ask("server.history.list")["jobs"]
    claim("history", [(job["filename"], job["status"]) for job in jobs] == [(name, "completed")], jobs)


def homes(page, claim):
    page.said.clear()
    page.ask("printer.gcode.script", 60, script="G28")
    places = [params[0]["toolhead"]["position"] for method, params in page.said
              if method == "notify_status_update" and "position" in params[0].get("toolhead", {})]
    claim("told of its moves while it homes", len(places) > 2, places)
    page.wait("notify_status_update", 5, lambda params: params[0].get("toolhead", {}).get("homed_axes") == "xyz")


def calibrates(rig, page, claim):
    page.ask("printer.gcode.script", 120, script=CALIBRATES)
    store = [entry["message"] for entry in page.ask("server.gcode_store")["gcode_store"]]
    claim("gcode_store", CALIBRATES in store and any("delta_radius: 130." in told for told in store), store)
    waits = page.ask("printer.objects.query", objects={"configfile": ["save_config_pending"]})
    claim("save_config_pending", waits["status"]["configfile"]["save_config_pending"], waits)
    try:
        page.ask("printer.gcode.script", script="SAVE_CONFIG")
    except Refused:
        pass  # The host goes before it has answered.
    page.wait("notify_klippy_disconnected")
    page.wait("notify_klippy_ready")
    claim("ready after SAVE_CONFIG", page.ask("server.info")["klippy_state"] == "ready")
    faults = compare(saved_by(rig))
    claim("what is saved is near the truth", not faults, faults)


def stops(page, claim):
    page.ask("printer.emergency_stop")
    page.wait("notify_klippy_shutdown")
    info = page.ask("printer.info")
    claim("stopped", info["state"] == "shutdown" and STOPPED in info["state_message"], info)
    told = page.refusal("printer.gcode.script", script="G28")
    claim("no moves when stopped", STOPPED in told, told)
    page.ask("printer.firmware_restart")
    page.wait("notify_klippy_ready")
    claim("ready after the stop", page.ask("server.info")["klippy_state"] == "ready")
    page.ask("printer.objects.subscribe", objects={"toolhead": None})
    homes(page, claim)


def run(caltwin, host, moonraker, folder, claim):
    config = folder / "data" / "config"
    config.mkdir(parents=True)
    with socket.create_server(("127.0.0.1", 0)) as free:
        port = free.getsockname()[1]
    with Rig(caltwin, host, folder, machine_of(folder), TRUTH, ["--fidelity", "fast"]) as rig:
        rig.config = rig.config.rename(config / "printer.cfg")  # Where pages edit it.
        with open(rig.config, "a", encoding="utf-8") as file:
            file.write(FOR_PAGES.format(folder=folder))
        (config / "moonraker.conf").write_text(MOONRAKER_CONF.format(folder=folder, port=port))
        rig.start([moonraker, "-d", folder / "data", "-n"], "moonraker.log")
        rig.start_host()
        try:
            talk(rig, port, claim)
        except (HostError, Refused, OSError) as error:
            log = (folder / "moonraker.log").read_text(errors="replace")
            claim(f"{type(error).__name__}: {error}{rig.logs()}\n--- moonraker.log\n{log[-3000:]}", False)


def talk(rig, port, claim):
    started = time.monotonic()

    def reached(what):
        print(f"{time.monotonic() - started:6.1f} s: {what}", flush=True)

    wait_until_ready(port)
    reached("ready")
    for origin, allowed in (("http://127.0.0.1:8080", True), ("http://elsewhere.invalid", False)):
        answer = call(port, "GET", "/printer/info", headers={"Origin": origin})
        claim(f"a page of {origin}", (answer[1]["Access-Control-Allow-Origin"] == origin) == allowed, answer)
    claim("a slicer", "OctoPrint" in call(port, "GET", "/api/version")[2]["text"])
    page = Page(port, call(port, "GET", "/access/oneshot_token")[2]["result"])
    asks_as_pages_do(page, port, claim)
    reached("asked")

    told = page.refusal("printer.gcode.script", script="G1 Z5")
    claim("not homed", "Must home first" in told, told)
    homes(page, claim)
    told = page.refusal("printer.gcode.script", script="G1 X500")
    claim("out of range", "Move out of range: 500.000" in told, told)
    reached("homed")
    prints(page, port, claim)
    reached("printed")

    calibrates(rig, page, claim)
    reached("calibrated and saved")
    stops(page, claim)
    reached(f"stopped and homed; {page.asked} calls over the websocket")


def main():
    if len(sys.argv) != 4:
        print(__doc__)
        return 2
    for program in sys.argv[2:]:
        if shutil.which(program) is None:
            print(f"skipped: {program} is not installed: tools/setup.sh --controllers")
            return SKIPPED
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(1))  # Its children are ended then too.
    claims, faults = [], []

    def claim(what, holds, found=""):
        claims.append(what)
        if not holds:
            faults.append(f"{what}: {found}")

    with tempfile.TemporaryDirectory() as folder:
        run(*sys.argv[1:], Path(folder), claim)
    print(*faults, f"{len(claims)} claims, {len(faults)} failed", sep="\n")
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
