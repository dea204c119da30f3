"""The server as its clients meet it: rest_test.py CALTWIN.

Starts `caltwin serve --http 0`, sends the requests of the published calibration interface as
printed, leads a procedure through its questions, kills the server in the middle of one, and
sends noise. No browser; the standard library alone.
"""

import json
import os
import random
import signal
import socket
import subprocess
import sys
import tempfile
import time

import siege
from served import JSON, Server, file_form, files_form

def published_requests(server):
    base = "/api/calibration"
    status, _ = server.ask("GET", base + "/bed-tilt/current")
    assert status == 404
    probe = server.done("POST", base + "/bed-tilt/probe",
                        {"probe_points": [[20, 20], [215, 20], [20, 215]], "use_printer": True,
                         "reference_height": 10.0})
    assert set(probe["plane_equation"]) == {"a", "b", "c"}
    assert {"tilt_x_degrees", "tilt_y_degrees"} <= set(probe["tilt_angles"])
    assert set(probe["z_offsets"]) == {"z1_mm", "z2_mm", "z3_mm"}
    assert probe["residual_mm"] == 0 and probe["measured_points"] == 3
    grid = server.done("POST", base + "/bed-tilt/calibrate",
                       {"grid_rows": 3, "grid_cols": 3, "reference_height": 10.0})
    assert grid["measured_points"] == 9
    assert server.done("GET", base + "/bed-tilt/current")["points"] == grid["points"]
    applied = server.done("POST", base + "/bed-tilt/apply-triple-z", grid["z_offsets"])
    assert applied["status"] == "success"
    valid = server.done("POST", base + "/validate",
                        {"test_points": [[100, 100, 10.0], [150, 150, 10.0], [200, 50, 10.0]]})
    assert {"status", "mean_error_mm", "max_error_mm", "std_error_mm", "num_points"} <= set(valid)
    assert server.done("GET", base + "/intrinsics")["fx"] == 900
    camera = {"fx": 905, "fy": 905, "cx": 640, "cy": 480, "k1": 0.1, "k2": 0, "p1": 0, "p2": 0}
    server.done("POST", base + "/intrinsics", camera)
    assert server.done("GET", base + "/intrinsics")["fx"] == 905
    assert "<h1>" in server.done("GET", base + "/report")
    assert "calibrations" in server.done("GET", base + "/report", headers={"Accept": "application/json"})


def lead(server, procedure, options, say_yes=True, until=()):
    """Runs a procedure to its end or to a question that begins so, answering what else it asks;
    the bench then."""
    server.done("POST", "/api/bench/procedures", {"procedure": procedure, "options": options})
    for _ in range(2000):
        bench = server.done("GET", "/api/bench")
        question = (bench["job"] or {}).get("question")
        if bench["state"] == "idle" or (question and question["text"].startswith(until)):
            return bench
        if question:
            answer = {"id": question["id"], "yes": say_yes}
            if "hint_mm" in question:
                answer["value_mm"] = question["hint_mm"]
            server.ask("POST", "/api/bench/answer", answer)
        time.sleep(0.01)
    raise AssertionError("the procedure did not end")


def a_machine_is_calibrated(server):
    before = server.done("GET", "/api/bench")["settings"]
    refused = lead(server, "next_cluster_backlash", {"axis": "x"}, say_yes=False)["job"]
    assert refused["result"]["ending"] == "refused", refused["result"]
    assert server.done("GET", "/api/bench")["settings"] == before
    job = lead(server, "next_cluster_backlash", {"axis": "x", "variant": "corrected"})["job"]
    assert job["result"]["ending"] == "done" and len(job["readings"]) > 20
    gap = server.done("GET", "/api/bench")["settings"]["backlash_mm"]["x"]
    assert abs(gap - 0.062) < 0.005, gap  # examples/practice has 0.062.
    assert f"X{gap:.4f}"[:6] in server.done("GET", "/api/bench/user-vars")
    status, _ = server.ask("POST", "/api/bench/procedures", {"procedure": "nonsense"})
    assert status == 422
    status, wrong = server.ask("POST", "/api/bench/procedures",
                               {"procedure": "next_cluster_backlash", "options": {"axes": "q"}})
    assert status == 422 and "did you mean" in json.dumps(wrong), wrong
    return gap


def the_session_is_versioned(server):
    session = server.done("GET", "/api/bench")["session"]
    kept = server.done("PATCH", "/api/bench/session",
                       {"version": session["version"], "entries": {"step": 3}})
    status, clash = server.ask("PATCH", "/api/bench/session",
                               {"version": session["version"], "entries": {"step": 4}})
    assert status == 409 and clash["entries"] == {"step": 3} and clash["version"] == kept["version"]


def the_bench_is_drawn(server):
    block = server.done("GET", "/api/bench")["artefacts"][0]
    assert block["type"] == "block123" and block["turn_deg"] == 0
    assert block["size_mm"] == [76.2, 50.8, 25.4]
    scene = server.done("GET", "/api/bench/scene")
    base = block["at_mm"]
    drawn = [geom for geom in scene["geoms"] if geom["size_mm"] == [38.1, 25.4, 12.7]]
    assert [geom["pose"][:3] for geom in drawn] == [[base[0], base[1], base[2] + 12.7]]

    def carriages(times):
        return server.done("POST", f"/api/bench/poses?exaggerate={times}",
                           {"positions": [[100, 100, 20]]})["poses"][0]

    # Carriages trail by half their hidden gap, at most 0.062 mm, drawn 100 times as large.
    apart = [abs(one - other) for few, many in zip(carriages(1), carriages(100))
             for one, other in zip(few, many)]
    assert abs(max(apart) - 99 * 0.062 / 2) < 1e-3, max(apart)


def a_real_machine_tells_nothing(program, state):
    words = [program, "serve", "--tcp", "0", "--fidelity", "fast"]
    machine = subprocess.Popen(words, stdout=subprocess.PIPE, text=True)
    try:
        port = next(line for line in machine.stdout if line.startswith("listening on")).split(":")[1]
        server = Server(program, state, "--machine", "gantry_router",
                        "--link", f"tcp:127.0.0.1:{port.strip()}")
        block = server.done("GET", "/api/bench")["artefacts"][0]
        assert block == {"id": "block", "type": "block123", "at_mm": None, "size_mm": None,
                         "turn_deg": None}
        status, problem = server.ask("GET", "/api/bench/scene?exaggerate=2")
        assert status == 404 and "real" in problem["detail"], problem
        status, _ = server.ask("POST", "/api/bench/poses", {"positions": [[1, 2, 3]]})
        assert status == 404
        server.end()
    finally:
        machine.kill()
        machine.wait()


def restored(server):
    server.done("POST", "/api/bench/restore")
    while server.done("GET", "/api/bench")["state"] != "idle":
        time.sleep(0.01)
    assert server.done("GET", "/api/bench")["settings"]["backlash_mm"]["x"] == 0


def begun_until_asked(server, procedure, options, texts=("Set ",)):
    """Answers yes to all but a question that begins so: the bench that stands at it."""
    bench = lead(server, procedure, options, until=texts)
    assert bench["state"] != "idle", bench["job"]["result"]
    return bench


def killed_in_a_procedure(program, state, gap):
    server = Server(program, state)
    before = begun_until_asked(server, "next_cluster_backlash", {"axis": "y"})
    server.end(signal.SIGKILL)
    server = Server(program, state)
    bench = server.done("GET", "/api/bench")
    assert bench["session"]["entries"] == {"step": 3} and bench["state"] == "idle"
    assert abs(bench["settings"]["backlash_mm"]["x"] - gap) < 1e-9, "settings outlive a kill"
    job = server.done("GET", "/api/bench/results")["results"][-1]
    assert job["result"]["ending"] == "interrupted" and "server ended" in job["result"]["messages"][0], job
    assert len(job["readings"]) > 20 and job["readings"] == before["job"]["readings"]
    assert job["said"] == before["job"]["said"] and job["options"] == {"axis": "y"}
    assert job["question"] == before["job"]["question"] and job["settings_now"] == bench["settings"]
    assert job["result"]["steps"] == [] and bench["results"][-1]["id"] == job["id"]
    assert server.done("GET", "/api/calibration/bed-tilt/current")["measured_points"] == 9
    job = lead(server, "next_cluster_backlash", {"axis": "y"})["job"]
    assert job["result"]["ending"] == "done" and job["id"] == before["job"]["id"] + 1
    restored(server)
    return server


def what_was_applied_outlives_a_kill(program, state, server):
    """Applied, then aborted and killed; applied, and killed in the same procedure."""
    for is_aborted in (True, False):
        options = {"axis": "x", "variant": "corrected"}
        asked = begun_until_asked(server, "next_cluster_backlash", options)
        was = asked["settings"]
        server.done("POST", "/api/bench/answer", {"id": asked["job"]["question"]["id"], "yes": True})
        while (bench := server.done("GET", "/api/bench"))["settings"]["backlash_mm"] == was["backlash_mm"]:
            assert bench["state"] != "idle", bench["job"]["result"]
        if is_aborted:
            server.ask("POST", "/api/bench/abort")
        server.end(signal.SIGKILL)
        server = Server(program, state)
        now = server.done("GET", "/api/bench")
        assert now["settings"] == bench["settings"], (now["settings"], bench["settings"])
        assert now["results"][-1]["result"]["ending"] in ("aborted", "interrupted", "done")
        restored(server)
    return server


def files_are_diagnosed(server):
    rows = "campaign,cmd_x_mm,dir_x,value_mm\n" + "".join(
        f"a,{x},{d},{0.04 * (d < 0) + 1e-4 * ((x * 7 + r * 3) % 5):.5f}\n"
        for r in range(3) for d in (1, -1) for x in range(0, 300, 20))
    body, headers = file_form("dial.csv", rows)
    answer = server.done("POST", "/api/diagnose", body, headers)
    assert answer["verdict"] in ("none", "named", "ambiguous", "unknown") and answer["import"]
    report = server.done("GET", f"/api/diagnoses/{answer['id']}/report")
    assert report.startswith("<!") and "dial.csv" in report
    assert "value_mm" in server.done("GET", f"/api/diagnoses/{answer['id']}/rows")
    body, headers = file_form("x.csv", "campaign,cmd_x_mm,value_mm\na,1,zwei\n")
    status, refused = server.ask("POST", "/api/diagnose", body, headers)
    assert status == 422 and refused["errors"][0]["line"] == 2, refused
    body, headers = file_form("dial.csv", rows, machine="/etc/passwd")
    assert server.ask("POST", "/api/diagnose", body, headers)[0] == 422
    for name, text in [("m.yaml", "extends: /etc/passwd\n"), ("m.yaml", "extends: ../../x.yaml\n"),
                       ("dial.yaml", "format: 1\nmachine: /etc/passwd\n"),
                       ("m.yaml", "format: 1\nname: m\nkinematics: cartesian\nmodel: /etc/passwd\n")]:
        body, headers = files_form({"dial.csv": rows, name: text})
        status, refused = server.ask("POST", "/api/diagnose", body, headers)
        assert status == 422 and "sent along" in json.dumps(refused), (name, text, status, refused)
    body, headers = files_form({f"dial{i}.csv": rows for i in range(17)})
    assert server.ask("POST", "/api/diagnose", body, headers)[0] == 422
    body, headers = file_form("dial.csv", rows, map="a" * 100_000)
    assert server.ask("POST", "/api/diagnose", body, headers)[0] == 422


def a_scenario_runs(server):
    begun = server.done("POST", "/api/runs",
                        {"scenario": "next_cluster_backlash_corrected", "fidelity": "fast"})
    for _ in range(1000):
        run = server.done("GET", "/api/runs/" + begun["id"])
        if run["state"] != "running":
            break
        time.sleep(0.05)
    assert run["state"] == "done" and run["result"]["passed"], run
    assert server.done("GET", f"/api/runs/{begun['id']}/report").startswith("<!")


def a_stop_holds_until_homed(server):
    """Whatever a client sends after an emergency stop, nothing moves before somebody homes."""
    home = {"procedure": "home", "options": {}}
    gap = {"procedure": "next_cluster_backlash", "options": {"axis": "x"}}
    lead(server, "home", {})
    server.done("POST", "/api/bench/procedures", gap)
    assert server.done("POST", "/api/bench/emergency-stop")["aborted"]
    while (bench := server.done("GET", "/api/bench"))["state"] != "idle":
        time.sleep(0.05)
    assert bench["is_stopped"] and bench["results"][-1]["result"]["ending"] == "aborted", bench["results"][-1]
    for method, path, body in [("POST", "/api/bench/procedures", gap), ("POST", "/api/bench/restore", None),
                               ("PATCH", "/api/bench/settings", {"backlash_mm": {"x": 0.01}})]:
        status, problem = server.ask(method, path, body)
        assert status == 409 and "emergency" in problem["detail"], (path, status, problem)
    assert server.done("POST", "/api/bench/procedures", home)["procedure"] == "home"
    while (bench := server.done("GET", "/api/bench"))["state"] != "idle":
        time.sleep(0.05)
    assert not bench["is_stopped"] and lead(server, "next_cluster_backlash", {"axis": "x"})["job"]["result"]["ending"] == "done"


def a_study_runs(program, state, server):
    asked = {"scenario": "next_cluster_backlash_corrected", "trials": 30, "seed": 7,
             "vary": {"backlash.x.gap_mm": {"normal": {"mean": 0.05, "sd": 0.01}}}}
    for wrong in [{"scenario": "../x"}, {**asked, "trials": 20_001}, {**asked, "fidelity": "linear"},
                  {**asked, "vary": {"nonsense": 1}}, {**asked, "extends": "/etc/passwd"}]:
        assert server.ask("POST", "/api/studies", wrong)[0] == 422, wrong
    _, fault = server.ask("POST", "/api/studies", {**asked, "vary": {"nonsense": 1}})
    assert fault["errors"][0]["pointer"] == "/vary" and "file" not in fault["errors"][0], fault
    _, fault = server.ask("POST", "/api/studies", [1])
    assert fault["errors"][0]["pointer"] == "", fault
    assert server.done("GET", "/api/studies")["studies"] == []
    long = server.done("POST", "/api/studies", {**asked, "trials": 20_000})
    status, busy = server.ask("POST", "/api/studies", asked)
    assert status == 409 and busy["running"] == long["id"], busy
    assert server.ask("GET", f"/api/studies/{long['id']}/report")[0] == 409
    home = lead(server, "home", {})["job"]
    assert home["result"]["ending"] == "done", "the bench goes on beside a study"
    while server.done("GET", f"/api/studies/{long['id']}")["progress"]["done"] == 0:
        time.sleep(0.05)
    assert server.ask("DELETE", f"/api/studies/{long['id']}")[0] == 204
    begun = server.done("POST", "/api/studies", asked)
    assert begun["id"] != long["id"], "the address of a deleted study leads to no other"
    while (study := server.done("GET", f"/api/studies/{begun['id']}"))["state"] == "running":
        time.sleep(0.05)
    assert study["state"] == "done" and study["progress"] == {"done": 30, "all": 30}, study
    assert study["summary"]["trials"] == 30 and "backlash.x" in study["text"], study
    assert server.done("GET", f"/api/studies/{begun['id']}/report").startswith("<!")
    server.done("POST", "/api/studies", {**asked, "trials": 20_000})
    server.end(signal.SIGKILL)
    server = Server(program, state)
    kept, ended = server.done("GET", "/api/studies")["studies"]
    assert kept["state"] == "done" and ended["state"] == "stopped", (kept, ended)
    assert server.done("GET", f"/api/studies/{begun['id']}")["summary"] == study["summary"]
    return server


def noise_leaves_it_answering(server, count):
    rng = random.Random(1)
    document = server.done("GET", "/api/openapi.json")
    paths = [path for path in document["paths"] if path != "/api/events"] + ["/", "/x", "/api/x"]
    methods = ["GET", "POST", "PUT", "PATCH", "DELETE", "HEAD", "OPTIONS"]
    bodies = ["", "{", "[]", "null", "{}", '{"z1_mm":1e999}', '{"probe_points":[[1,2],[3,4],["a",5]]}',
              "[" * 5000, '{"version":-1,"entries":[]}', "\x00\xff", '{"procedure":"\\u0000"}',
              '{"test_points":[[1,2,3]]}', '{"id":1}', '{"scenario":"../x"}', "a" * 2000]
    for _ in range(count):
        path = rng.choice(paths).replace("{id}", rng.choice(["1", "-1", "x%2Fy", "%00", "9" * 50]))
        path = path.replace("{name}", rng.choice(["backlash", "..", "%2e%2e", "gantry_router"]))
        if "picture" in path or "explain" in path:
            continue
        status, _ = server.ask(rng.choice(methods), path, rng.choice(bodies),
                               rng.choice([JSON, {}, {"Content-Type": "multipart/form-data; boundary=x"}]))
        assert status != 500, (path, status)
    for _ in range(200):
        with socket.create_connection(("127.0.0.1", server.port), 5) as raw:
            raw.sendall(bytes(rng.randrange(256) for _ in range(rng.randrange(1, 400))))
    assert server.done("GET", "/api")["name"] == "caltwin"


def no_other_site_reaches_it(server):
    for host in ["evil.example", "127.0.0.1.evil.example", "127.evil.example"]:
        named = {"Host": f"{host}:{server.port}", "Origin": f"http://{host}:{server.port}"}
        assert server.ask("POST", "/api/bench/abort", headers=named)[0] == 421, host
    tls = {"Origin": f"https://127.0.0.1:{server.port}"}
    assert server.ask("POST", "/api/bench/abort", headers=tls)[0] == 403
    assert server.ask("GET", "/api/machines", headers={"Sec-Fetch-Site": "cross-site"})[0] == 403


def strange_names_are_taken(server):
    for name in ["a" * 59 + "\u00e9", "\u4e2d" * 40, "x" * 5000]:
        status, _ = server.ask("POST", "/api/calibration/bed-tilt/calibrate", {},
                               headers={"X-Operator": name.encode()})
        assert status == 200, name
    assert server.done("GET", "/api/bench")["state"] == "idle"


def others_need_the_token(program, state):
    refused = subprocess.run([program, "serve", "--http", "0", "--listen", "0.0.0.0"],
                             capture_output=True, text=True, timeout=30)
    assert refused.returncode == 2 and "token" in refused.stderr, refused
    secret = os.path.join(state, "token")
    with open(secret, "w", encoding="utf-8") as out:
        out.write("a-secret-of-24-letters-x\n")
    server = Server(program, state, "--listen", "0.0.0.0", "--token-file", secret)
    assert server.ask("GET", "/api")[0] == 401
    assert server.ask("GET", "/api", headers={"Authorization": "Bearer wrong"})[0] == 401
    assert server.ask("GET", "/api",
                      headers={"Authorization": "Bearer a-secret-of-24-letters-x"})[0] == 200
    assert server.ask("GET", "/api",
                      headers={"Authorization": "bearer a-secret-of-24-letters-x"})[0] == 200
    assert server.end() == 130


def main():
    program = sys.argv[1]
    noise = int(sys.argv[2]) if len(sys.argv) > 2 else 1500
    with tempfile.TemporaryDirectory() as state:
        server = Server(program, state)
        published_requests(server)
        gap = a_machine_is_calibrated(server)
        the_session_is_versioned(server)
        the_bench_is_drawn(server)
        server.end(signal.SIGKILL)
        server = killed_in_a_procedure(program, state, gap)
        server = what_was_applied_outlives_a_kill(program, state, server)
        files_are_diagnosed(server)
        a_scenario_runs(server)
        a_stop_holds_until_homed(server)
        server = a_study_runs(program, state, server)
        no_other_site_reaches_it(server)
        strange_names_are_taken(server)
        noise_leaves_it_answering(server, noise)
        siege.slow_clients_lock_nobody_out(server)
        siege.uploads_together_are_bounded(server)
        assert server.end() == 130
        others_need_the_token(program, state)
        a_real_machine_tells_nothing(program, state)
    print("all is answered")


if __name__ == "__main__":
    main()
