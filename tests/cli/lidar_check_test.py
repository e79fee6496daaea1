"""S61 for LIDARs: `raycube check` on a shipped LIDAR scene, its text, JSON and file, and how it is refused."""

import json
import pathlib
import sys
import tempfile

from driver import Program

program = Program(sys.argv[1])
run, check = program.run, program.check
scene = pathlib.Path(sys.argv[2]) / "lidar" / "pipeline_dial.toml"

with tempfile.TemporaryDirectory() as folder:
    report = json.loads(run("check", scene, "--pulses", 6, "--json", "-o", folder).stdout)["dial"]
    check(report == json.loads((pathlib.Path(folder) / "dial_check" / "check.json").read_text()))
    check(report["passed"] is True and report["failures"] == [], report)
    check(report["pulses"] == 6 and report["rays"] % 6 == 0)
    causes = ["agree", "exact_tie", "edge_tie", "depth_tie", "grazing", "unexplained"]
    check(sum(report["hits_" + cause] for cause in causes) == report["rays"] and report["hits_unexplained"] == 0)
    check(
        report["compared_pulses"] + report["parted_pulses"] + report["edge_pulses"] == 6
        and report["beyond_pulses"] == 0
    )
    check(0 < report["median"] <= report["worst"] < report["worst_limit"] == 1e-5, report)
    check(report["ledger_closure"] < 1e-6 and report["ledger_difference"] < 1e-6)
    check(0 < report["air"]["worst"] < 1e-3, report["air"])
    program.refused("check", scene, "--pulses", 6, "-o", folder, status=2, says=["dial_check"])

text = run("check", scene, "--pulses", 2).stdout
check(text.startswith("LIDAR dial on ") and text.endswith("check: within limits\n"), text)
check("pulses 2, rays" in text and "bins, over the peak bin: median of pulses" in text, text)
program.refused("check", scene, "--instrument", "radar", status=2, says=["radar", "dial"])
print(f"lidar check: {program.checks} checks")
