#!/usr/bin/env python3
"""`raycube render` when the machine or the user stops it (REQUIREMENTS section 4, Machine): one clear error with its
way out, the documented exit status, and never a half-written file under a final name.
usage: render_failures_test.py RAYCUBE"""

import os
import pathlib
import resource
import signal
import sys
import tempfile

import patience
from driver import Program, record, scene

program = Program(sys.argv[1])
run, check, refused = program.run, program.check, program.refused


def files(folder):
    """Every file below a folder, hidden ones too."""
    return sorted(path for path in pathlib.Path(folder).rglob("*") if not path.is_dir())


def content(folder):
    return {path: path.read_bytes() for path in files(folder)}


with tempfile.TemporaryDirectory() as work:
    work = pathlib.Path(work)
    tiny = scene(work, "tiny.toml")
    long = scene(work, "long.toml", pixels=2000, lines=2000, grid=31)
    before = set(files(work))

    # Usage and places
    refused("render", work / "none.toml", "-o", work / "o", status=2, says=["none.toml"])
    refused(
        "render", tiny, "-o", work / "o", "--instrument", "spectir", status=2, says=["'spectir'", "there are: camera"]
    )
    refused("render", tiny, "-o", tiny, status=3, says=["tiny.toml is a file", "another -o"])
    refused("render", tiny, "-o", "/proc/raycube-out", status=3, says=["/proc/raycube-out", "-o"])
    refused("render", tiny, "-o", work / "o", "--device", "nonesuch", status=2, says=["nonesuch", "  0: "], messages=2)
    refused(
        "render",
        tiny,
        "-o",
        work / "o",
        status=4,
        says=["no OpenCL device", "pocl-opencl-icd"],
        env={"OCL_ICD_VENDORS": "/nonexistent"},
    )
    # A driver that is there and cannot be loaded: what the loader says of it, as an error of the environment.
    (work / "vendors").mkdir()
    (work / "vendors/broken.icd").write_text("/nonexistent/libbroken.so\n")
    before = set(files(work))
    says = ["no OpenCL device", "broken.icd names /nonexistent/libbroken.so", "No such file or directory"]
    vendors = {"OCL_ICD_VENDORS": str(work / "vendors")}
    refused("render", tiny, "-o", work / "o", status=3, says=says, messages=2, env=vendors)
    if "pocl" in run("devices", "--json").stdout.lower():
        little = 200 << 20  # its compiler's library alone is larger
        refused(
            "render",
            tiny,
            "-o",
            work / "o",
            status=3,
            says=["no OpenCL device", "200 MiB of address space (ulimit -v)", "cannot be loaded: "],
            messages=2,
            preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_AS, (little, little)),
        )
    check(set(files(work)) == before and not (work / "o").exists())

    # Too little memory: the error names the need, and that much is enough.
    done = refused(
        "render", tiny, "-o", work / "o", "--memory", "1K", status=2, says=["--memory is too small", "raise --memory"]
    )
    need = int(done.stderr.split("need ")[1].split(" bytes")[0])
    check(set(files(work)) == before)
    refused("render", tiny, "-o", work / "o", "--memory", str(need - 1), status=2, says=[f"need {need} bytes"])
    done = run("render", tiny, "-o", work / "o", "--memory", str(need), "--log", "/dev/full")
    check(done.stderr.count("--log /dev/full: cannot be written") == 1, done.stderr)
    digest = record(work / "o" / "camera")["digest"]

    # What is there stays as it is unless --overwrite is given.
    kept = content(work / "o")
    refused("render", tiny, "-o", work / "o", status=2, says=["is there already", "--overwrite"])
    check(content(work / "o") == kept)
    run("render", tiny, "-o", work / "o", "--overwrite")
    check(record(work / "o" / "camera")["digest"] == digest and set(content(work / "o")) == set(kept))

    # A read-only place, and a disk without room for the cube (11.5 kB): known before the first ray, nothing left. As
    # mounts of a namespace of its own, since root may write into any folder.
    place = work / "mounted"
    place.mkdir()

    def on_mount(options, says):
        script = (
            f'mount -t tmpfs -o {options} none {place} || exit 99; "$0" "$@"; s=$?; ls -AR {place}/out >&2; exit $s'
        )
        done = patience.run(
            ["unshare", "-m", "sh", "-c", script, program.path, "render", tiny, "-o", place / "out", "-q"],
            capture_output=True,
            text=True,
        )
        check(done.returncode == 3 and done.stdout == "" and done.stderr.count("error: ") == 1, done)
        check(
            all(part in done.stderr for part in says) and "radiance" not in done.stderr.split("\n", 1)[1], done.stderr
        )

    if patience.run(["unshare", "-m", "mount", "-t", "tmpfs", "none", place], capture_output=True).returncode == 0:
        on_mount("ro", [f"{place}/out/camera: cannot be written", "Read-only file system", "-o"])
        on_mount("size=8k", ["radiance.img: no room for", "free some space", "-o"])
    else:
        print(
            "render failures: SKIPPED the read-only and the full disk: mounts need root and CAP_SYS_ADMIN", flush=True
        )

    # Two runs into one folder: the second is refused. Ctrl-C and SIGTERM: status 130, nothing left.
    for number in (signal.SIGINT, signal.SIGTERM):
        process = program.mid_render(long, work / "long")
        if number == signal.SIGINT:
            refused("render", tiny, "-o", work / "long", status=3, says=["another run is writing", "choose another -o"])
        out, err = patience.signalled(process, number)
        check(
            process.returncode == 130 and out == "" and err.count("error: ") == 1 and "interrupted" in err,
            process.returncode,
            out,
            err,
        )
        check(files(work / "long") == [], files(work / "long"))

    # kill -9: only hidden temporaries are left, and the next run removes them.
    process = program.mid_render(long, work / "long")
    process.kill()
    patience.end_of(process)
    left = files(work / "long")
    check(left and all(path.name.startswith(".") for path in left), left)
    run("render", tiny, "-o", work / "long")
    check(record(work / "long" / "camera")["digest"] == digest)
    check({path.name for path in files(work / "long")} == {path.name for path in kept})

    # A signal of a fault: the status stays the signal's, the report says what was being done, what was half written
    # goes. (LLVM's handler takes the first one that is sent, once it has built a kernel: the program goes on as it
    # would for it.)
    if "RAYCUBE_SANITIZED" not in os.environ:  # the sanitizers report such signals themselves
        process = program.mid_render(long, work / "fault")
        process.send_signal(signal.SIGCONT)

        def ended():
            process.send_signal(signal.SIGSEGV)  # where the first is at work already, others wait for its end
            return process.poll() is not None

        patience.until(ended, "the end by SIGSEGV", glance_s=0.3)
        err = patience.end_of(process)[1]
        check(process.returncode == -signal.SIGSEGV and err.count("error: ") == 1, process.returncode, err)
        for part in (
            "ended by signal 11 (SIGSEGV",
            ": command '",
            ": rendering instrument 'camera'\n",
            "kernels launched last: ",
            "trace_primary",
            "stack (addr2line",
            "/libc.so.6(",
        ):
            check(part in err, part, err)
        check(not any(".img." in path.name for path in files(work / "fault")), files(work / "fault"))

    # No linker: the driver gives up in the middle of a kernel, and that is not for a damaged cache.
    if "pocl" in run("devices", "--json").stdout.lower():
        (work / "empty").mkdir()
        refused(
            "render",
            tiny,
            "-o",
            work / "unlinked",
            status=3,
            says=["links kernels by the program 'ld'", "PATH", "binutils"],
            env={"POCL_CACHE_DIR": str(work / "empty"), "PATH": str(work / "empty")},
        )
        check(files(work / "unlinked") == [])

    # A damaged kernel cache: the driver gives up, the program says so with the way out. An empty cache is no damage.
    cache = work / "cache"
    cache.mkdir()
    run("render", tiny, "-o", work / "cold", env={"POCL_CACHE_DIR": str(cache)})
    check(record(work / "cold" / "camera")["digest"] == digest)
    cached = [path for path in files(cache) if path.suffix in (".so", ".bc")]
    if cached:
        for suffix in (".so", ".bc"):
            for path in cached:
                if path.suffix == suffix:
                    path.write_bytes(b"garbage")
            refused(
                "render",
                tiny,
                "-o",
                work / "damaged",
                status=4,
                says=["kernel cache", "POCL_CACHE_DIR"],
                env={"POCL_CACHE_DIR": str(cache)},
            )
            check(files(work / "damaged") == [])
    else:
        print("render failures: SKIPPED the damaged kernel cache: this OpenCL driver is not PoCL", flush=True)
print(f"render failures: {program.checks} checks")
