#!/usr/bin/python3
"""Each kernel against what the machine can do, by what it really computes: bench/flops.py [--launcher CMD]

Floating-point operations and bytes are counted by oclgrind (bench/flops_plugin.cpp) on pixels of the park and on pulses
of its survey; seconds are those of `raycube_bench roofline` and of a render of the survey. Needs Debian's oclgrind; the
headers that the plugin is compiled against come with `ci/setup --counter`. Writes build/bench/flops.json and flops.md,
which bench/tables.py puts into bench/RESULTS.md.

Counted pixels are whole lines of the image that is timed, rendered alone; the simulator's radiance must be the device's
of the same line to a few roundings, and the timed image's but for other sky directions. LIDAR pulses are few of a
slower laser on the same path.
"""

import argparse
import concurrent.futures
import json
import os
import pathlib
import re
import shlex
import subprocess

import numpy as np

ROOT = pathlib.Path(__file__).resolve().parent.parent
WORK = ROOT / "build/bench/flops"
PARK = ROOT / "build/bench/scene"
PROGRAM = ROOT / "build/raycube"
LINES = (16, 48, 80, 112)  # of the timed image's 128, each half a line south of the round metre
PULSES = 160

# Lanes to operations. Comparisons are a unit's work as additions are; signs, masks and copies are bits.
ARITHMETIC = {
    "fadd": 1,
    "fsub": 1,
    "fmul": 1,
    "fdiv": 1,
    "frem": 1,
    "fma": 2,
    "mad": 2,
    "fmuladd": 2,
    "sqrt": 1,
    "native_recip": 1,
}
FUNCTIONS = {
    "sin",
    "cos",
    "tan",
    "asin",
    "acos",
    "atan",
    "atan2",
    "exp",
    "exp2",
    "log",
    "log2",
    "pow",
    "cbrt",
    "erf",
    "erfc",
    "sincos",
    "hypot",
    "pown",
    "rsqrt",
    "expm1",
    "log1p",
    "sinh",
    "cosh",
    "tanh",
    "tgamma",
    "lgamma",
}
COMPARISONS = {"fcmp", "fmin", "fmax", "min", "max", "clamp"}
BITS = {"fabs", "copysign", "select", "floor", "ceil", "rint", "round", "trunc", "fmod", "ldexp", "nextafter"}


def base_name(name):
    """fma of _Z3fmaDv16_fS_S_ or of llvm.fma.v16f32."""
    if name.startswith("llvm."):
        return name.split(".")[1]
    mangled = re.match(r"_ZL?(\d+)", name)
    return name[mangled.end() : mangled.end() + int(mangled[1])] if mangled else name


def operations(lanes):
    """(arithmetic, comparisons, functions) of a kernel's lanes by name; a name that is none of the known ones ends the
    program."""
    sums = [0, 0, 0]
    for name, count in lanes.items():
        base = base_name(name)
        if base in ARITHMETIC:
            sums[0] += ARITHMETIC[base] * count
        elif base in COMPARISONS:
            sums[1] += count
        elif base in FUNCTIONS:
            sums[2] += count
        elif not (base in BITS or base.startswith(("vload", "vstore", "convert_", "as_"))):
            raise SystemExit(
                f"flops: the kernels call {name}, which bench/flops.py does not know; put it where it belongs"
            )
    return sums


def build_plugin():
    peers = ROOT / "build/peers/oclgrind/usr"
    include = next(
        (
            p
            for p in (peers / "lib/llvm-14/include", pathlib.Path("/usr/lib/llvm-14/include"))
            if (p / "llvm/IR/Function.h").exists()
        ),
        None,
    )
    if include is None or not (peers / "include/oclgrind/Plugin.h").exists():
        raise SystemExit("flops: no headers of oclgrind and LLVM 14 to count with; run ci/setup --counter")
    library = WORK / "libflops.so"
    subprocess.run(
        [
            "g++",
            "-std=c++17",
            "-O2",
            "-shared",
            "-fPIC",
            "-fno-rtti",
            "-isystem",
            peers / "include",
            "-isystem",
            include,
            "-isystem",
            peers / "include/llvm-14",
            "-isystem",
            peers / "include/llvm-c-14",
            ROOT / "bench/flops_plugin.cpp",
            "-o",
            library,
        ],
        check=True,
    )
    return library


def counted(library, name, simulation, instrument, launcher):
    """Counts of one render under oclgrind; several may run at once."""
    counts = WORK / f"{name}.json"
    counts.unlink(missing_ok=True)  # a plugin that cannot be loaded is only warned of
    environment = {**os.environ, "RAYCUBE_FLOPS": str(counts)}
    subprocess.run(
        [
            *launcher,
            "oclgrind",
            "--plugins",
            library,
            "--build-options",
            "-DRC_NO_PREFETCH",
            PROGRAM,
            "render",
            simulation,
            "--instrument",
            instrument,
            "--threads",
            "1",
            "-q",
            "--overwrite",
            "-o",
            WORK / name,
        ],
        check=True,
        env=environment,
        stdout=subprocess.DEVNULL,
    )
    return json.loads(counts.read_text())


def line_of_park(line):
    """The timed simulation with a single one of its lines."""
    text = (PARK / "park_roofline.toml").read_text()
    start = text.index('name = "spectir"')
    end = text.index("[[instrument]]", start)
    part, found = re.subn(r"^lines = 128$", "lines = 1", text[start:end], flags=re.M)
    part, also = re.subn(r"^center_m = \[0\.0, 0\.0\]$", f"center_m = [0.0, {63.5 - line}]", part, flags=re.M)
    if (found, also) != (1, 1):
        raise SystemExit("flops: the park's spectir has no 128 lines about (0, 0) any more; this script counts on them")
    file = PARK / f"park_flops_{line}.toml"
    file.write_text(text[:start] + part + text[end:])
    return file


def radiance(folder):
    """[line, sample, band]: what no file of the park asks to be otherwise."""
    image = json.loads((folder / "run.json").read_text())["image"]
    return np.fromfile(folder / "radiance.img", "<f4").reshape(image["lines"], image["samples"], image["bands"])


def cube(library, launcher):
    """Rows of the cube's kernels: per pixel and second."""
    figures = WORK / "roofline.json"
    subprocess.run(
        [*launcher, ROOT / "build/raycube_bench", "--json", figures, "--scene", PARK / "park.toml", "roofline"],
        check=True,
    )
    run = json.loads((PARK / "roofline_out/spectir/run.json").read_text())
    timed = radiance(PARK / "roofline_out/spectir")
    files = {line: line_of_park(line) for line in LINES}
    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        parts = list(pool.map(lambda line: counted(library, f"line{line}", files[line], "spectir", launcher), LINES))
    off = 0.0
    for line in LINES:
        subprocess.run(
            [
                *launcher,
                PROGRAM,
                "render",
                files[line],
                "--instrument",
                "spectir",
                "-q",
                "--overwrite",
                "-o",
                WORK / "device",
            ],
            check=True,
            stdout=subprocess.DEVNULL,
        )
        simulated, device = radiance(WORK / f"line{line}/spectir")[0], radiance(WORK / "device/spectir")[0]
        worst = np.max(np.abs(simulated / device - 1))
        if not worst < 1e-5:
            raise SystemExit(
                f"flops: line {line} as simulated differs from the device's by {worst:.3g}: what was counted is not "
                f"what is timed"
            )
        off += np.mean(np.abs(simulated / timed[line] - 1)) / len(LINES)
    if not off < 0.02:
        raise SystemExit(
            f"flops: the lines counted differ from those timed by {off:.3g} in the mean; they should be the same places"
        )
    pixels = run["image"]["samples"] * run["image"]["lines"]
    rows = []
    for kernel in ("trace_primary", "make_surface", "trace_sun", "trace_sky", "shade", "resolve", "integrate_bands"):
        seconds = run["stage_s"]["integrate" if kernel == "integrate_bands" else kernel] / pixels
        rows.append(
            row(kernel, "pixel", [part[kernel] for part in parts], len(LINES) * run["image"]["samples"], seconds)
        )
    return rows, json.loads(figures.read_text()), off


def without_air(survey):
    """oclgrind 21.10 does not know what LLVM leaves in the kernel of the air's beam
    (llvm.experimental.noalias.scope.decl)."""
    head, rest = survey.split("[atmosphere]", 1)
    return head + '[atmosphere]\nmodel = "none"\n' + rest[rest.index("[time]") :]


def pulses(library, launcher):
    """Rows of the LIDAR's kernels, which one stage's seconds hold together."""
    survey = (PARK / "park_survey.toml").read_text()
    few, found = re.subn(r"^pulses = 40000$", f"pulses = {PULSES}", survey, flags=re.M)
    few, also = re.subn(
        r"^prf_khz = 30\.0$", f"prf_khz = {30 * PULSES / 40000 * 1.021:.6f}", few, flags=re.M
    )  # no multiple of the mirror's 60 Hz
    if (found, also) != (1, 1):
        raise SystemExit("flops: the park's survey has no 40000 pulses at 30 kHz any more; this script counts on them")
    for name, text in (("park_flops_survey", few), ("park_clear_survey", survey)):
        (PARK / f"{name}.toml").write_text(without_air(text))
    for _ in range(2):  # the first compiles
        subprocess.run(
            [*launcher, PROGRAM, "render", PARK / "park_clear_survey.toml", "-q", "--overwrite", "-o", WORK / "survey"],
            check=True,
            stdout=subprocess.DEVNULL,
        )
    run = json.loads((WORK / "survey/survey/run.json").read_text())
    counts = counted(library, "few_pulses", PARK / "park_flops_survey.toml", "survey", launcher)
    together = {"launches": 0, "loaded_bytes": 0, "stored_bytes": 0, "lanes": {}}
    for kernel, part in counts.items():
        if not kernel.startswith("lidar"):
            continue
        for key in ("launches", "loaded_bytes", "stored_bytes"):
            together[key] += part[key]
        for name, lanes in part["lanes"].items():
            together["lanes"][name] = together["lanes"].get(name, 0) + lanes
    return [row("lidar_shots, 64 sub-rays, no air", "pulse", [together], PULSES, run["stage_s"]["pulses"] / 40000)]


def row(kernel, unit, parts, units, seconds):
    sums = np.sum([operations(part["lanes"]) for part in parts], axis=0)
    moved = [sum(part[key] for part in parts) / units for key in ("loaded_bytes", "stored_bytes")]
    return {
        "kernel": kernel,
        "per": unit,
        "seconds": seconds,
        "flop": sums[0] / units,
        "comparisons": sums[1] / units,
        "functions": sums[2] / units,
        "loaded_bytes": moved[0],
        "stored_bytes": moved[1],
    }


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--launcher", default="", help="put before every process")
    launcher = shlex.split(parser.parse_args().launcher)
    WORK.mkdir(parents=True, exist_ok=True)
    library = build_plugin()
    rows, roof, off = cube(library, launcher)
    rows += pulses(library, launcher)
    peak, bandwidth = 1e9 * roof["roofline_fma_gflop_s"], 1e9 * roof["roofline_write_gb_s"]
    keys, table = {}, [
        "| kernel | per | ns | flop (comparisons) | Gflop/s | of the FMA peak | comparisons counted too | bytes asked "
        "of memory | GB/s | over write bandwidth | flop per byte |",
        "|---|---|---|---|---|---|---|---|---|---|---|",
    ]
    for r in rows:
        moved = r["loaded_bytes"] + r["stored_bytes"]
        rate, both = r["flop"] / r["seconds"], (r["flop"] + r["comparisons"]) / r["seconds"]
        flop = f"{r['flop']:.3g} ({r['comparisons']:.2g})" + (
            f" and {r['functions']:.2g} functions" if r["functions"] >= 0.5 else ""
        )
        table.append(
            f"| {r['kernel']} | {r['per']} | {1e9 * r['seconds']:.3g} | {flop} | {1e-9 * rate:.3g} | "
            f"{100 * rate / peak:.2g} % | {100 * both / peak:.2g} % | {moved:.3g} | "
            f"{1e-9 * moved / r['seconds']:.3g} | {moved / r['seconds'] / bandwidth:.2g} | {r['flop'] / moved:.2g} |"
        )
        name = re.sub(r"\W+", "_", r["kernel"]).lower()
        keys[f"flops_{name}_of_fma_peak"] = rate / peak
        keys[f"flops_{name}_bytes_over_write_bandwidth"] = moved / r["seconds"] / bandwidth
    text = "\n".join(table) + (
        f"\n\nThe machine, all threads: {1e-9 * peak:.0f} Gflop/s in chains of fused multiply-adds (two each), "
        f"{1e-9 * bandwidth:.0f} GB/s of plain writes. Counted on {len(LINES)} lines of "
        f"128 pixels (their radiance against the timed image's: {100 * off:.2g} % in the mean, other sky directions) "
        f"and {PULSES} pulses.\n"
    )
    (ROOT / "build/bench/flops.md").write_text(text)
    (ROOT / "build/bench/flops.json").write_text(json.dumps({"rows": rows, "keys": keys}, indent=1) + "\n")
    print(text)


if __name__ == "__main__":
    main()
