#!/usr/bin/python3
"""A LIDAR run from pulse to file: bench/lidar_run.py [--runs N] [--raycube PROGRAM]

The survey of bench/lidar_run.toml: 666 667 pulses of 19 sub-rays over 1110 triangles, 380 bins, waveforms drawn,
echoes fitted, LAS 1.4 of format 9 with its packets, hashes of both. As it is, and with a noisy detector (dark counts
of 1e6 Hz, 300 electrons of readout noise, gain 20, 12 bits). Checked first: every pulse has its return, no light is
lost, ranges are those of the surfaces. Then whole runs of the program from start to end, in turn, and their processor
seconds (user and system, all threads):

lidar_run_pulses_per_cpu_s        pulses over them, clean; HELIOS++ 2.0.1 with full waveforms and fits, 60 000 where it
                                  was measured (a shared machine of 2 cores, 11.1 processor seconds)
lidar_run_noisy_pulses_per_cpu_s  the same with noise
lidar_run_vs_trace                a clean run's seconds over those of its tracing alone
lidar_run_resident_mb             most memory above what one pulse takes, of 1e5 and 1e6 pulses the more

The machine should be otherwise idle. Written to build/bench/lidar_run.json.
"""

import argparse
import json
import os
import pathlib
import re
import statistics
import subprocess

import numpy as np

ROOT = pathlib.Path(__file__).resolve().parents[1]
WORK = ROOT / "build/bench/lidar_run"
NOISE = "dark_rate_hz = 1e6\nreadout_noise_e = 300.0\ngain = 20.0\nionization_ratio = 0.2\nbits = 12\n"
GOALS = {"lidar_run_pulses_per_cpu_s": 120e3, "lidar_run_noisy_pulses_per_cpu_s": 60e3}


def write_blocks(file):
    """The blocks of lidar_bench.cpp: ground in nine strips, 91 boxes."""
    corners, faces = [], []

    def corner(x, y, z):
        corners.append((x, y, z))
        return len(corners)

    def quad(a, b, c, d):
        faces.extend(((a, b, c), (a, c, d)))

    for i in range(9):
        low, high = -120 + i * 240 / 9, -120 + (i + 1) * 240 / 9
        quad(corner(-120, low, 0), corner(120, low, 0), corner(120, high, 0), corner(-120, high, 0))
    for i in range(91):
        x, y, half, height = -95 + 19 * (i % 10) + i % 3, -95 + 19 * (i // 10) + i % 5, 3 + i % 4, 3 + i % 12
        v = [
            corner(x + half * (1, -1)[1 - (k & 1)], y + half * (1, -1)[1 - (k >> 1 & 1)], height * (k >> 2))
            for k in range(8)
        ]
        for q in ((4, 5, 7, 6), (0, 2, 3, 1), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)):
            quad(*(v[k] for k in q))
    lines = [f"v {x:.9g} {y:.9g} {z:.9g}" for x, y, z in corners] + [f"f {a} {b} {c}" for a, b, c in faces]
    file.write_text("\n".join(lines) + "\n")


def survey(name, pulses=None, noisy=False):
    text = (ROOT / "bench/lidar_run.toml").read_text()
    if pulses:
        text = re.sub(r"(?m)^pulses = \d+$", f"pulses = {pulses}", text)
    if noisy:
        text = text.replace('mode = "linear"\n', 'mode = "linear"\n' + NOISE)
    file = WORK / f"{name}.toml"
    file.write_text(text)
    return file


def run(program, file):
    """Processor seconds, seconds, most resident bytes and run.json of a run."""
    out = WORK / "out"
    command = [program, "render", file, "-o", out, "--overwrite", "--quiet"]
    child = subprocess.Popen([str(part) for part in command], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    _, status, usage = os.wait4(child.pid, 0)
    if status != 0:
        raise SystemExit(f"lidar_run: {file.name} failed")
    record = json.loads((out / "blocks/run.json").read_text())
    return usage.ru_utime + usage.ru_stime, usage.ru_maxrss * 1024, record


def validate(record):
    """Every pulse finds something, all light is accounted for, first returns lie on surfaces."""
    figures = record["lidar"]
    assert figures["pulses"] > 0 and figures["pulses_without_return"] < 1e-3 * figures["pulses"], figures
    assert record["survey"]["worst_ledger_error"] < 1e-6, record["survey"]
    las = np.memmap(WORK / "out/blocks/returns.las", np.uint8, "r")
    start, length, count = (
        int(las[a:b].view(t)[0]) for a, b, t in ((96, 100, "<u4"), (105, 107, "<u2"), (247, 255, "<u8"))
    )
    points = las[start : start + count * length].reshape(count, length)
    base = 59  # of format 9; then pulse_id, range, range_true
    measured, true = (points[:, base + at : base + at + 8].copy().view("<f8")[:, 0] for at in (8, 16))
    off = (measured - true)[np.isfinite(true)]
    # c/2 s / sqrt(N) of 4e5 photo-electrons: 0.4 mm; edges of blocks are worse, noise is too.
    assert np.median(np.abs(off)) < 2e-3 and abs(np.median(off)) < 1e-4, (np.median(np.abs(off)), np.median(off))
    return float(np.median(np.abs(off)))


def spread(key, values):
    out = {
        key: statistics.median(values),
        key + "_min": min(values),
        key + "_max": max(values),
        key + "_runs": len(values),
    }
    if key in GOALS:
        out.update({key + "_goal": GOALS[key], key + "_goal_is": "at least"})
    return out


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--runs", type=int, default=5)
    parser.add_argument("--raycube", type=pathlib.Path, default=ROOT / "build/raycube")
    options = parser.parse_args()
    WORK.mkdir(parents=True, exist_ok=True)
    write_blocks(WORK / "blocks.obj")
    clean, noisy = survey("clean"), survey("noisy", noisy=True)
    errors = [validate(run(options.raycube, file)[2]) for file in (clean, noisy)]
    pulses, clean_rates, noisy_rates, ratios = 666667, [], [], []
    for _ in range(options.runs):
        seconds, _, record = run(options.raycube, clean)
        clean_rates.append(pulses / seconds)
        ratios.append(record["survey"]["pulses"] / record["survey"]["pulses_per_s"] / record["stage_s"]["pulses"])
        noisy_rates.append(pulses / run(options.raycube, noisy)[0])
    resident = {count: run(options.raycube, survey("memory", count))[1] for count in (1, 100_000, 1_000_000)}
    keys = {
        **spread("lidar_run_pulses_per_cpu_s", clean_rates),
        **spread("lidar_run_noisy_pulses_per_cpu_s", noisy_rates),
        **spread("lidar_run_vs_trace", ratios),
        "lidar_run_resident_mb": max(resident[100_000], resident[1_000_000]) / 1e6 - resident[1] / 1e6,
        "lidar_run_resident_mb_goal": 40,
        "lidar_run_resident_mb_goal_is": "at most",
        "lidar_run_resident_1e5_mb": resident[100_000] / 1e6,
        "lidar_run_resident_1e6_mb": resident[1_000_000] / 1e6,
    }
    text = "| figure | median [lowest .. highest] | goal |\n|---|---|---|\n"
    for key in [k for k in keys if not k.endswith(("_min", "_max", "_runs", "_goal", "_goal_is"))]:
        between = f" [{keys[key + '_min']:.4g} .. {keys[key + '_max']:.4g}]" if key + "_min" in keys else ""
        goal = ""
        if key + "_goal" in keys:
            sense, bound = keys[key + "_goal_is"], keys[key + "_goal"]
            met = keys[key] >= bound if sense == "at least" else keys[key] <= bound
            goal = f"{sense} {bound:.6g}, {'met' if met else 'missed'}"
        text += f"| `{key}` | {keys[key]:.4g}{between} | {goal} |\n"
    text += (
        f"\nMedian distance of measured from true ranges: {1e3 * errors[0]:.1f} mm clean, {1e3 * errors[1]:.1f} mm "
        f"noisy; {options.runs} runs each, in turn.\n"
    )
    (ROOT / "build/bench/lidar_run.json").write_text(json.dumps({"keys": keys, "text": text}, indent=1) + "\n")
    print(text)


if __name__ == "__main__":
    main()
