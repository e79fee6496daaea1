#!/usr/bin/env python3
"""Puts measured figures where people read them: bench/tables.py PART ... (PART: groups, trace_once, mitsuba, bounces,
park_bounced, scaling, leaf_level, flops, planner, waits, analysis, lidar_run)

Adds what the scripts measured (build/bench/PART.json) to build/bench.json and renews the tables between `<!-- ci/bench
PART -->` and `<!-- end -->` in bench/RESULTS.md and README.md. ci/bench calls it with what it
has just run.
"""

import json
import pathlib
import re
import sys
import textwrap

ROOT = pathlib.Path(__file__).resolve().parent.parent
BENCH = ROOT / "build/bench.json"
SUFFIXES = ("_min", "_max", "_runs", "_goal", "_goal_is")


def number(value):
    if float(value).is_integer() and abs(value) < 1e6:
        return str(int(value))
    return f"{value:.3g}"


def groups(figures):
    """Every number of bench.json: the median, extremes and number of runs, the goal and whether it is met."""
    lines = [
        f"Commit {figures['commit']}; {figures['cpu']}, {figures['hardware_threads']} hardware threads, "
        f"{figures.get('device', '')}.",
        "",
        "| figure | median [lowest .. highest] (runs) | goal |",
        "|---|---|---|",
    ]
    for key, value in figures.items():
        if isinstance(value, str) or key.endswith(SUFFIXES):
            continue
        spread = (
            f" [{number(figures[key + '_min'])} .. {number(figures[key + '_max'])}]" if key + "_min" in figures else ""
        )
        runs = f" ({figures[key + '_runs']})" if key + "_runs" in figures else ""
        goal = ""
        if key + "_goal" in figures:
            sense, bound = figures[key + "_goal_is"], figures[key + "_goal"]
            met = value >= bound if sense == "at least" else value <= bound
            goal = f"{sense} {number(bound)}, {'met' if met else 'missed'}"
        lines.append(f"| `{key}` | {number(value)}{spread}{runs} | {goal} |")
    return "\n".join(lines) + "\n"


def readme_speed(figures):
    """The table of speeds on README.md, from what `ci/bench` measured last."""
    f = {key: value for key, value in figures.items() if not isinstance(value, str)}
    rows = (
        (
            "primary rays, terrain of 1 M triangles",
            f"{f['primary_mrays_s']:.0f} Mrays/s, {f['primary_vs_embree16']:.1f} x",
            "Embree 3.13 `rtcIntersect16` coherent",
        ),
        ("sun rays, the same terrain", f"{f['shadow_vs_embree16']:.1f} x", "`rtcOccluded16` coherent"),
        (
            "primary rays among leaves (park); sun rays there",
            f"{f['park_leaf_primary_vs_embree16']:.1f} x, {f['park_leaf_primary_vs_best_embree']:.1f} x; "
            f"{f['park_leaf_shadow_vs_embree16']:.1f} x",
            "`rtcIntersect16` coherent, the fastest of its modes; `rtcOccluded16` coherent",
        ),
        (
            "primary rays among 2, 7 and 14 layers of leaves",
            ", ".join(f"{f[f'layers{n}_primary_vs_embree16']:.1f} x" for n in (2, 7, 14)),
            "`rtcIntersect16` coherent",
        ),
        (
            "kernels built from nothing; from the cache",
            f"{f['kernel_build_cold_s']:.1f} s; {f['kernel_build_cached_s']:.2f} s",
            "",
        ),
        (
            "band integration, 4 / 8 terms",
            f"{f['integrate4_vs_write_bandwidth']:.2f} x / {f['integrate8_vs_write_bandwidth']:.2f} x",
            f"plain write bandwidth ({f['write_bandwidth_gb_s']:.0f} GB/s)",
        ),
        (
            "360 bands of the park with opaque leaves, light scattered once: 12.4 M primary and 12.4 M sun rays, "
            "49.6 M into the sky",
            f"{f['park_render_s']:.0f} s",
            "",
        ),
    )
    return (
        f"| speed ({figures['cpu']}, {figures['hardware_threads']} threads); x: rays or bytes a second, raycube's over "
        f"the baseline's | figure | baseline |\n|---|---|---|\n"
        + "".join(f"| {what} | {figure} | {baseline} |\n" for what, figure, baseline in rows)
    )


def readme_mitsuba(data):
    facts, best = data["scene"], data["fastest"]
    return (
        f"Against Mitsuba 3.9.1 by one render for every three bands ({best}, the fastest of its variants that run; "
        f"{facts['pixels']} x {facts['pixels']} pixels, "
        f"360 bands, {facts['triangles_placed'] / 1e6:.0f} M placed triangles, sun and even sky, direct light, 2 "
        f"threads): "
        f"{data['cube_vs_mitsuba3_equal_error']:.0f} x faster at equal rms error of the median band "
        f"[{data['cube_vs_mitsuba3_equal_error_min']:.0f} .. {data['cube_vs_mitsuba3_equal_error_max']:.0f} over "
        f"errors], load and compilation left out "
        "on both sides, raycube's plan and writing counted ([bench/RESULTS.md](bench/RESULTS.md)).\n"
        f"{data['what_an_expert_would_use']}\n"
    )


def readme_bounces(data):
    stock, clever, few = (
        data[f"bounced_cube_vs_{name}_equal_error"] for name in ("mitsuba3", "clever", "clever_of_16")
    )
    return (
        f"With light between surfaces, on the same scene and by the *worst* of nine bands: {stock:.0f} x faster than "
        f"Mitsuba's path integrator, {clever:.1f} x than a script that renders {data['skeleton']} wavelengths with it "
        f"and multiplies them by raycube's matrix ({few:.1f} x with 16, whatever that leaves out); band means of both "
        f"are {100 * data['agreement_mean_worst']:.1g} % apart at most (`ci/bench bounces`).\n"
    )


def waits(keys):
    """What one waits for, now and, where that was measured in the same run, before."""
    tasks = (
        ("starter", "the cube of `raycube new`'s scene, 64 x 64 pixels of 98 bands"),
        ("study", "a detection study: fifteen cubes of 64 x 64 pixels and 200 bands, with one's plan"),
        ("park", "the park at 3 %: 320 x 320 pixels, 360 bands, 10 M triangles (before: light scattered once)"),
        ("emit", "276 bands of 100 x 100 pixels of 60 m over 10 000 trees, as EMIT sees them"),
        ("preview", "a first picture of the park"),
    )
    what, commit = "what one waits for, from the command to its end (air and kernels cached)", keys.get("waits_before")
    lines = (
        [f"| {what} | now, s | before (commit {commit}), s |", "|---|---|---|"]
        if commit
        else [f"| {what} | s |", "|---|---|"]
    )
    for name, text in tasks:
        before = keys.get(f"wait_{name}_before_s")
        was = f" {before:.2g} |" if before is not None else " there was none |"
        lines.append(f"| {text} | {keys[f'wait_{name}_s']:.2g} |{was if commit else ''}")
    return "\n".join(lines) + "\n"


def analysis(keys):
    """`raycube analyze` on a cube of 2 GB against what a user would run instead."""
    rows = (
        ("ACE, maps and all", "detect", "numpy reading the file (`np.fromfile`)", "read", "analyze_ace_vs_read"),
        ("eigenvectors", "eigen", "the same", "read", "analyze_eigen_vs_read"),
        ("k-means, 5 classes", "kmeans", "scikit-learn's rounds alone", "sklearn", "analyze_kmeans_vs_sklearn"),
        ("k-means, 5 classes", "kmeans", "`spectral`, from 5 rounds on a fifth", None, "analyze_kmeans_vs_spectral"),
        ("unmixing, 4 endmembers", "unmix", "scipy's nnls, from 20 000 pixels", None, "analyze_unmix_vs_scipy"),
    )
    lines = ["| 2332 x 1000 pixels, 224 bands, float32 | s | against | s | ratio | goal |", "|---|---|---|---|---|---|"]
    for what, ours, against, theirs, key in rows:
        other = f"{keys[f'analyze_{theirs}_s']:.2g}" if theirs else ""
        goal = f"{keys[key + '_goal_is']} {keys[key + '_goal']}"
        lines.append(f"| {what} | {keys[f'analyze_{ours}_s']:.2g} | {against} | {other} | {keys[key]:.2g} | {goal} |")
    return "\n".join(lines) + f"\n\nResident for ACE: {keys['analyze_ace_mb']:.0f} MB.\n"


def renew(path, part, text):
    """Replaces what stands between the markers of `part`. A page without them is left as it is; True when it had
    them."""
    page = path.read_text()
    pattern = re.compile(rf"(<!-- ci/bench {re.escape(part)} -->\n).*?(<!-- end -->)", re.S)
    if not pattern.search(page):
        return False
    path.write_text(pattern.sub(lambda m: m[1] + prose_wrapped(text) + m[2], page, count=1))
    return True


def prose_wrapped(text):
    """The same words with no line of prose past 120 columns; rows of tables stay whole (test line_width)."""
    wrapper = textwrap.TextWrapper(width=120, break_long_words=False, break_on_hyphens=False)
    lines = text.split("\n")
    return "\n".join(line if line.startswith("|") or len(line) <= 120 else wrapper.fill(line) for line in lines)


def main(parts):
    figures = json.loads(BENCH.read_text()) if BENCH.exists() else {}
    texts = {}
    if "trace_once" in parts:
        figures.update(json.loads((ROOT / "build/bench/trace_once.json").read_text())["keys"])
        texts["trace_once"] = (ROOT / "build/bench/trace_once.md").read_text()
    if "mitsuba" in parts:
        data = json.loads((ROOT / "build/bench/mitsuba.json").read_text())
        keys = {k: v for k, v in data.items() if k.startswith("cube_vs_mitsuba3")}
        figures.update(
            keys,
            cube_vs_mitsuba3_equal_error_goal=50.0,
            cube_vs_mitsuba3_equal_error_goal_is="at least",
            mitsuba_variant=data["fastest"],
            mitsuba_agreement_mean_worst=data["agreement_mean_worst"],
        )
        texts["mitsuba"] = (ROOT / "build/bench/mitsuba.md").read_text()
        renew(ROOT / "README.md", "mitsuba", readme_mitsuba(data))
    if "bounces" in parts:
        data = json.loads((ROOT / "build/bench/mitsuba_bounces.json").read_text())
        for key, goal in (("mitsuba3", 50.0), ("clever", 1.5), ("clever_of_16", None)):
            key = f"bounced_cube_vs_{key}_equal_error"
            figures[key] = data[key]
            if goal:
                figures.update({f"{key}_goal": goal, f"{key}_goal_is": "at least"})
        figures["mitsuba_bounces_agreement_mean_worst"] = data["agreement_mean_worst"]
        texts["bounces"] = (ROOT / "build/bench/mitsuba_bounces.md").read_text()
        renew(ROOT / "README.md", "bounces", readme_bounces(data))
    if "park_bounced" in parts:
        figures.update(json.loads((ROOT / "build/bench/park_bounced.json").read_text())["keys"])
        texts["park_bounced"] = (ROOT / "build/bench/park_bounced.md").read_text()
    if "scaling" in parts:
        figures.update(json.loads((ROOT / "build/bench/scaling.json").read_text())["keys"])
        texts["scaling"] = (ROOT / "build/bench/scaling.md").read_text()
    if "leaf_level" in parts:
        figures.update(json.loads((ROOT / "build/bench/leaf_level.json").read_text())["keys"])
        texts["leaf_level"] = (ROOT / "build/bench/leaf_level.md").read_text()
    if "flops" in parts:
        figures.update(json.loads((ROOT / "build/bench/flops.json").read_text())["keys"])
        texts["flops"] = (ROOT / "build/bench/flops.md").read_text()
    if "waits" in parts:
        waited = json.loads((ROOT / "build/bench/waits.json").read_text())
        figures.update(waited)
        texts["waits"] = waits(waited)
        renew(ROOT / "README.md", "waits", waits(waited))
    if "analysis" in parts:
        found = json.loads((ROOT / "build/bench/analysis.json").read_text())
        figures.update(found)
        texts["analysis"] = analysis(found)
    if "lidar_run" in parts:
        data = json.loads((ROOT / "build/bench/lidar_run.json").read_text())
        figures.update(data["keys"])
        texts["lidar_run"] = data["text"]
    if "planner" in parts:
        figures.update(json.loads((ROOT / "build/bench/planner.json").read_text())["keys"])
        texts["planner"] = (ROOT / "build/bench/planner.md").read_text()
    BENCH.write_text(json.dumps(figures, indent=2) + "\n")
    if "groups" in parts:
        texts["groups"] = groups(figures)
        if all(f"layers{n}_primary_vs_embree16" in figures for n in (2, 7, 14)):  # a run of every group
            renew(ROOT / "README.md", "speed", readme_speed(figures))
    for part, text in texts.items():
        if not renew(ROOT / "bench/RESULTS.md", part, text):
            raise SystemExit(
                f"tables: bench/RESULTS.md has no lines '<!-- ci/bench {part} -->' and '<!-- end -->'; put them where "
                f"the table belongs"
            )
    print(f"tables: {', '.join(texts)} renewed; {BENCH.relative_to(ROOT)} has {len(figures)} keys")


if __name__ == "__main__":
    main(sys.argv[1:])
