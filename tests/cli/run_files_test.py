#!/usr/bin/env python3
"""What a run leaves on the disk is what it computed, as one set, whatever happens around it: closed descriptors,
readers that go, signals, kill -9 at any instant; the hashes in run.json are those of the files, and `raycube info
--verify` finds any difference. usage: run_files_test.py RAYCUBE [--full]
Without --full: one run is interrupted while it compiles, 6 s each, and 8 are killed."""

import hashlib
import json
import os
import pathlib
import random
import resource
import shutil
import signal
import subprocess
import sys
import tempfile
import time

import patience
from driver import FULL, PULSE_AND_RECEIVER, Program, record, scene

program = Program(sys.argv[1])
run, check, refused = program.run, program.check, program.refused
BLOCK = 4 << 20


def check_hashes(folder):
    """run.json against hashlib on the files: every file of the folder but run.json, every block, and the list."""
    folder = pathlib.Path(folder)
    hashes = record(folder)["sha256"]
    check(hashes["block_bytes"] == BLOCK)
    check(
        set(hashes["files"]) == {path.name for path in folder.iterdir()} - {"run.json"},
        list(hashes["files"]),
        list(folder.iterdir()),
    )
    for name, said in hashes["files"].items():
        content = (folder / name).read_bytes()
        blocks = [hashlib.sha256(content[at : at + BLOCK]) for at in range(0, len(content), BLOCK)]
        check(said["bytes"] == len(content) and said["blocks"] == [block.hexdigest() for block in blocks], name)
        check(said["list"] == hashlib.sha256(b"".join(block.digest() for block in blocks)).hexdigest(), name)


def verified(folder, status, *says):
    done = run("info", "--verify", folder, status=status)
    for part in says:
        check(part in done.stdout, part, done.stdout)
    return done.stdout


def content(folder):
    return {path.name: path.read_bytes() for path in pathlib.Path(folder).iterdir()}


def closed(work, tiny):
    """With any of descriptors 0 to 2 closed the products are those of a run with all of them open: a message that comes
    between the last strip and the names, as that of adaptive samples, would go into whatever file has number 2."""
    tiny.write_text(tiny.read_text().replace("samples = { grid = [3, 3] }", "samples = { lattice = 64, first = 16 }"))
    run("render", tiny, "-o", work / "open")
    good = content(work / "open/camera")
    for number, closing in enumerate(["<&-", ">&-", "2>&-", "<&- 2>&-", "<&- >&- 2>&-", ">&- 2>&-"]):
        out = work / f"closed{number}"
        done = patience.run(
            ["sh", "-c", f'exec "$0" "$@" {closing}', program.path, "render", tiny, "-o", out, "--verbose"],
            capture_output=True,
            text=True,
        )
        # The paths of the cubes, which go to stdout, are lost where it is closed: that is said by the status, and on
        # stderr if it can be.
        check(done.returncode == (3 if ">&-" in closing.replace("2>&-", "") else 0), closing, done)
        here = content(out / "camera")
        check(set(here) == set(good), closing, set(here))
        for name in ("radiance.img", "radiance.hdr", "truth.img", "truth.hdr", "quicklook.png"):
            check(here[name] == good[name], closing, name)
        verified(out / "camera", 0)


def hashes(work, tiny):
    for interleave, scale in (
        ("bip", ""),
        ("bil", ""),
        ("bsq", ""),
        ("bip", "integer_scale = 100.0"),
        ("bsq", "integer_scale = 100.0"),
    ):
        # 700 x 330 pixels of 10 bands: 9.2 MB of float, strips of some lines, planes that no block divides.
        more = f'interleave = "{interleave}"\n{scale}'
        file = scene(work, "hashes.toml", pixels=700, lines=330, grid=1, instrument=more)
        run("render", file, "-o", work / "h", "--overwrite", "--memory", "8M" if interleave == "bsq" else "2G")
        check_hashes(work / "h/camera")
        check(len(record(work / "h/camera")["sha256"]["files"]["radiance.img"]["blocks"]) == (2 if scale else 3))
        verified(work / "h/camera", 0, "6 of 6 files are as they were written")
    for inside in ("false", "true"):
        lidar = work / "lidar.toml"
        lidar.write_text(
            tiny.read_text().split("[[instrument]]")[0]
            + '[[lidar]]\nname = "als"\naltitude_agl_m = 600.0\nprf_khz = 10.0\npulses = 3000\n'
            + PULSE_AND_RECEIVER
            + f"[lidar.sampling]\nsubrays = 4\n[lidar.gate]\nstart_range_m = 585.0\nbins = 400\n[lidar.products]\n"
            f"png = false\ninternal_waveforms = {inside}\n"
        )
        run("render", lidar, "-o", work / "l", "--overwrite")
        files = set(content(work / "l/als"))
        check(
            {"returns.las", "waveforms.img", "returns.csv", "pulses.csv"} <= files
            and ("returns.wdp" in files) == (inside == "false"),
            files,
        )
        check_hashes(work / "l/als")
        check(verified(work / "l/als", 0).count("\n") == 1)


def verification(work, big):
    run("render", big, "-o", work / "v")
    folder = work / "v/camera"
    whole = content(folder)
    check_hashes(folder)
    cube = folder / "radiance.img"
    size = cube.stat().st_size
    check(size > 2 * BLOCK)

    def with_byte(at):
        data = bytearray(whole["radiance.img"])
        data[at] ^= 1
        cube.write_bytes(data)

    for block, at in ((0, 0), (0, BLOCK - 1), (1, BLOCK), (2, size - 1)):
        with_byte(at)
        last = min((block + 1) * BLOCK, size) - 1
        verified(folder, 1, f"radiance.img: block {block} of 3 (bytes {block * BLOCK} to {last}): not what was written")
    found = json.loads(run("info", "--verify", "--json", folder, status=1).stdout)
    check(found["whole"] is False and len(found["differences"]) == 1, found)
    cube.write_bytes(whole["radiance.img"][:-5])
    verified(folder / "run.json", 1, "block 2 of 3", f"at byte {size - 5} of {size}")
    cube.write_bytes(whole["radiance.img"] + b"x")
    verified(folder, 1, f"has {size + 1} bytes, {size} were written")
    cube.unlink()
    (folder / "truth.hdr").write_bytes(b"ENVI\n")
    done = verified(folder, 1, "radiance.img: is missing", "truth.hdr: block 0 of 1")
    check(done.count("\n") == 3, done)
    os.mkfifo(cube)
    verified(folder, 1, "radiance.img: is no plain file")
    cube.unlink()
    for name, data in whole.items():
        (folder / name).write_bytes(data)
    verified(folder, 0)

    # Records that cannot serve: of before the hashes, damaged, leading outside.
    def with_record(change):
        json_record = json.loads(whole["run.json"])
        change(json_record)
        (folder / "run.json").write_text(json.dumps(json_record))

    with_record(lambda r: r.pop("sha256"))
    refused("info", "--verify", folder, status=2, says=["no member \"sha256\"", "render again"])
    with_record(lambda r: r["sha256"]["files"]["radiance.img"]["blocks"].reverse())
    refused("info", "--verify", folder, status=2, says=["its own list of blocks of radiance.img is damaged"])
    # Sizes that nobody wrote: refused before anything of that size is taken.
    for size in (0, (64 << 20) + 1, 1 << 62, (1 << 64) - 1):
        with_record(lambda r: r["sha256"].update(block_bytes=size))
        refused("info", "--verify", folder, status=2, says=["run.json: is damaged: its block_bytes", f"(found {size})"])
    with_record(lambda r: r["sha256"]["files"]["truth.hdr"].update(bytes=(1 << 64) - 1))
    refused("info", "--verify", folder, status=2, says=["its own list of blocks of truth.hdr is damaged"])
    with_record(lambda r: r["sha256"]["files"].update({"../x": r["sha256"]["files"]["truth.hdr"]}))
    refused("info", "--verify", folder, status=2, says=["outside its folder"])
    with_record(lambda r: r["sha256"]["files"].update({"radiance.img": 5}))
    refused("info", "--verify", folder, status=2, says=["cannot be read as a run record"])
    refused("info", "--verify", folder / "truth.hdr", status=2, says=["--verify wants a run's folder"])


def readers_that_go(work, tiny):
    process = subprocess.Popen(
        [program.path, "render", tiny, "-o", work / "gone", "--verbose"],
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
    )
    process.stderr.readline()
    process.stderr.close()
    patience.until(lambda: process.poll() is not None, "the end of the run whose messages nobody reads")
    check(process.returncode == 0, process.returncode)
    verified(work / "gone/camera", 0)
    done = patience.run(
        [
            "bash",
            "-c",
            'set -o pipefail; "$0" render "$1" -o "$2" --verbose 2>&1 | head -1; echo ${PIPESTATUS[0]}',
            program.path,
            tiny,
            work / "gone2",
        ],
        capture_output=True,
        text=True,
    )
    verified(work / "gone2/camera", 0)
    # A report that nobody reads ends quietly, as other tools do.
    read, write = os.pipe()
    os.close(read)
    process = patience.run(
        [program.path, "info", work / "gone/camera/radiance.img", "--bands"],
        stdout=write,
        stderr=subprocess.PIPE,
        text=True,
    )
    os.close(write)
    check(process.returncode == -signal.SIGPIPE and process.stderr == "", process)


def children_of(pid):
    """Processes that any thread of this one has started and that live."""
    found = []
    try:
        for thread in pathlib.Path(f"/proc/{pid}/task").iterdir():
            found += (thread / "children").read_text().split()
    except OSError:
        pass
    return found


def signals(work, tiny, long):
    process = program.mid_render(long, work / "hup")
    out, err = patience.signalled(process, signal.SIGHUP)
    check(
        process.returncode == 130 and "interrupted by SIGHUP" in err and err.count("error: ") == 1,
        process.returncode,
        err,
    )
    check(not (work / "hup").exists(), "an empty folder is left")
    # Not where somebody said nohup: what ends that run is the signal after.
    process = program.mid_render(long, work / "hup", preexec_fn=lambda: signal.signal(signal.SIGHUP, signal.SIG_IGN))
    process.send_signal(signal.SIGHUP)
    out, err = patience.signalled(process, signal.SIGTERM)
    check(
        process.returncode == 130 and "interrupted by SIGTERM" in err and err.count("error: ") == 1,
        process.returncode,
        err,
    )
    for trial in range(6 if FULL else 1):
        if not interrupted_while_it_compiles(work, tiny, work / f"cold{trial}"):
            print("run files: SKIPPED Ctrl-C while kernels are built: this OpenCL driver starts no linker", flush=True)
            break


def interrupted_while_it_compiles(work, tiny, cache):
    """Ctrl-C while the driver compiles kernels, which reaches the linker that it starts too: at that very moment. False
    where the run ends without one."""
    cache.mkdir()
    process = program.start(
        *("render", tiny, "-o", work / "cold", "-q"),
        env={"POCL_CACHE_DIR": str(cache), "XDG_CACHE_HOME": str(cache)},
        start_new_session=True,
    )

    def halted_at_a_linker():
        if process.poll() is not None:
            return True
        if not children_of(process.pid):
            return False
        patience.halted(process)
        # The driver cannot have heard of a linker's end since: one that is there still is what it waits for.
        if any(patience.status_of(child, "State")[:1] not in ("", "Z", "X") for child in children_of(process.pid)):
            return True
        process.send_signal(signal.SIGCONT)
        return False

    patience.until(halted_at_a_linker, "a linker that the OpenCL driver starts", glance_s=0)
    found = process.poll() is None
    if found:
        os.killpg(process.pid, signal.SIGINT)
        process.send_signal(signal.SIGCONT)
    out, err = patience.end_of(process)
    check(process.returncode == (130 if found else 0), process.returncode, err)
    shutil.rmtree(cache)
    shutil.rmtree(work / "cold", ignore_errors=True)
    return found


def kills(work):
    """kill -9 at random instants of a run that replaces another: always one set or the other, after one look at
    most."""
    files = [scene(work, f"kill{i}.toml", pixels=40 + 8 * i, lines=20, grid=1) for i in (0, 1)]
    out, draw = work / "kill", random.Random(1)
    digests = set()
    for i in (0, 1):
        run("render", files[i], "-o", out, "--overwrite")
        digests.add(record(out / "camera")["digest"])
    begin = time.monotonic()
    for i in (0, 1):
        run("render", files[i], "-o", out, "--overwrite")
    longest = time.monotonic() - begin  # spreads the instants; what is asked holds at any of them
    old = new = 0
    trials = 24 if FULL else 8
    for trial in range(trials):
        before = record(out / "camera")["digest"]
        process = subprocess.Popen(
            [program.path, "render", files[trial % 2], "-o", out, "--overwrite", "-q"],
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )
        if trial % 2:
            time.sleep(draw.uniform(0, longest / 2))
        else:  # in the middle of the names
            patience.until(
                lambda: process.poll() is not None or (out / "camera/.raycube-publication").exists(),
                "the journal of a publication",
                glance_s=0.0002,
            )
            time.sleep(draw.uniform(0, 0.004))
        process.kill()
        process.wait()
        verified(out / "camera", 0)
        check(record(out / "camera")["digest"] in digests)
        if record(out / "camera")["digest"] == before:
            old += 1
        else:
            new += 1
    print(f"run files: of {trials} runs killed {old} kept the old set and {new} have the new one")
    run("render", files[0], "-o", out, "--overwrite")
    check(
        set(content(out / "camera")) == set(record(out / "camera")["sha256"]["files"]) | {"run.json"},
        list((out / "camera").iterdir()),
    )
    # Leftovers of files that the next run does not write are swept as well.
    for name in (".standard_error.img.raycube-abcdef", ".pictures.json.raycube-abcdef.points.png"):
        (out / "camera" / name).write_bytes(b"x")
    run("render", files[0], "-o", out, "--overwrite")
    check(not [path for path in (out / "camera").iterdir() if path.name.startswith(".")])


def later_failure(work):
    """Two instruments, the second of which finds no room (a limit on the size of files stands for a full disk): the
    first stays, whole. The limit lies between what the OpenCL driver writes of a program's text, 1.1 MB, and the cube's
    4 MB."""
    file = scene(work, "two.toml")
    text = file.read_text()
    file.write_text(
        text
        + text[text.index("[[instrument]]") :]
        .replace('name = "camera"', 'name = "late"')
        .replace("pixels = 24", "pixels = 1000")
        .replace("lines = 12", "lines = 100")
    )
    done = refused(
        "render",
        file,
        "-o",
        work / "two",
        status=3,
        says=["two/late/", ".img: writing failed", "whole and kept: ", "two/camera; go on with --instrument late"],
        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (1 << 21, 1 << 21)),
    )
    verified(work / "two/camera", 0)
    check(not (work / "two/late").exists(), "an empty folder is left")
    run("render", file, "-o", work / "two", "--instrument", "late")
    verified(work / "two/late", 0)


def nested(work):
    """A record whose own member nests 200 000 levels deep: before, `info --json` ran out of stack."""
    deep = 200000
    text = (work / "plain/camera/run.json").read_text().rstrip()
    (work / "nested").mkdir()
    (work / "nested/run.json").write_text(text[:-1] + ',"more":' + "[" * deep + "]" * deep + "}")
    for options in ([], ["--json"], ["--verify"]):
        refused("info", *options, work / "nested", status=2, says=["run.json", "is the file whole?"])


with tempfile.TemporaryDirectory() as work:
    work = pathlib.Path(work)
    tiny = scene(work, "tiny.toml")
    closed(work, scene(work, "adaptive.toml"))
    hashes(work, tiny)
    verification(work, scene(work, "big.toml", pixels=700, lines=340, grid=1))
    readers_that_go(work, tiny)
    signals(work, tiny, scene(work, "long.toml", pixels=2000, lines=2000, grid=11))
    kills(work)
    later_failure(work)
    run("render", tiny, "-o", work / "plain", "--overwrite")
    nested(work)
print(f"run files: {program.checks} checks")
