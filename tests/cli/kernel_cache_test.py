#!/usr/bin/env python3
"""Where compiled kernels are kept (host/cl/kernel_cache.h): a folder of the user's own that is checked, healed and
swept; a private one without a home; one error where the disk is full. The oracle is the digest of a run with the
driver's own cache. usage: kernel_cache_test.py RAYCUBE TWO_KERNELS [--full]
Without --full: what is kept, what is damaged (in half of the ways) and what has no home, of TWO_KERNELS: a program that
compiles two kernels of a line each, 1 s, where a render compiles for 3 to 12 s. Of the render, that it heals what is
damaged, and that it takes what came with the program. The other cases find an empty cache each, and so compile all
kernels anew."""

import fcntl
import hashlib
import os
import pathlib
import resource
import shutil
import signal
import sys
import tempfile
import time

import patience
from driver import FULL, Program, own_cache, record, scene

program = Program(sys.argv[1])
check = program.check
TWO_KERNELS = pathlib.Path(sys.argv[2]).resolve()
SHARED_PLACES = [pathlib.Path("/tmp/.cache/pocl"), pathlib.Path("/tmp/.cache/raycube"), pathlib.Path("/tmp/pocl")]


def environment(work, **more):
    """A bare machine: homes and temporary files under `work`, nothing of the user's, no kernels with the program."""
    kept = {
        name: value
        for name, value in os.environ.items()
        if name not in ("HOME", "XDG_CACHE_HOME", "POCL_CACHE_DIR", "TMPDIR")
    }
    for place in ("tmp", "data"):
        (work / place).mkdir(exist_ok=True)
    more = {"TMPDIR": work / "tmp", "RAYCUBE_DATA": work / "data", **more}
    return {**kept, **{name: str(value) for name, value in more.items()}}


def command(work, out, whole):
    render = [program.path, "render", work / "tiny.toml", "-o", out, "--overwrite"]
    return render if whole else [TWO_KERNELS]


def render(work, name, env, status=0, warnings=0, says=(), whole=FULL, **more):
    """A render of the small scene, or two kernels; returns (its digest, or their sums, and stderr)."""
    out = work / "out" / name
    done = patience.run(command(work, out, whole), env=env, capture_output=True, text=True, **more)
    check(done.returncode == status, name, done.returncode, done.stderr)
    check(done.stderr.count("raycube: warning: ") == warnings, name, done.stderr)
    for part in says:
        check(part in done.stderr, name, part, done.stderr)
    if status != 0:
        check(done.stderr.count("raycube: error: ") == 1, name, done.stderr)
    if status != 0:
        return "", done.stderr
    return record(out / "camera")["digest"] if whole else done.stdout, done.stderr


def kept_in(folder):
    return sorted(folder.glob("*.kernels"))


def mode(path):
    return path.stat().st_mode & 0o7777


def home_of_its_own(work, digest):
    """The first run keeps, the second takes; private, and nothing beside it."""
    env = environment(work, HOME=work / "home")
    (work / "home").mkdir()
    store = work / "home/.cache/raycube/kernels"
    check(render(work, "cold", env)[0] == digest)
    kept = {path: path.read_bytes() for path in kept_in(store)}
    check(len(kept) >= 2 and mode(store) == 0o700 and all(mode(path) == 0o600 for path in kept), kept.keys())
    check(sorted(store.iterdir()) == sorted(kept), list(store.iterdir()))  # this run's own folder is gone
    for content in kept.values():  # the intermediate code, too, so that no later process reads the source
        check("raycube-code.bc" in names(unpacked(content)), list(unpacked(content)))
    check(not (work / "home/.cache/pocl").exists() and list((work / "tmp").iterdir()) == [])
    for path in kept:
        os.utime(path, (time.time() - 3600,) * 2)  # file systems tell times to a few milliseconds, or seconds
    before = max(path.stat().st_mtime for path in kept)
    check(render(work, "warm", env)[0] == digest)
    check({path: path.read_bytes() for path in kept_in(store)} == kept)
    check(all(path.stat().st_mtime > before for path in kept))  # used, so not the next to be swept
    return env, store, kept


def damage(work, env, store, kept, digest):
    """Whatever is done to a file: one warning each, the same result, and the file whole again."""
    victim, whole = min(kept.items(), key=lambda item: len(item[1]))  # the soonest compiled
    middle = len(whole) // 2
    ways = {
        "cut short": whole[:middle],
        "empty": b"",
        "garbage": b"garbage",
        "longer": whole + b"x",
        "one bit": whole[:middle] + bytes([whole[middle] ^ 1]) + whole[middle + 1 :],
        "another program's": next(content for path, content in kept.items() if path != victim),
    }
    for name in ways if FULL else ("cut short", "one bit", "another program's"):
        victim.write_bytes(ways[name])
        check(render(work, name, env, warnings=1, says=[str(victim), "damaged", "compiled anew"])[0] == digest)
        check(victim.stat().st_size > middle, name)
        check(render(work, name, env)[0] == digest)
    victim.unlink()
    victim.symlink_to(work / "elsewhere")
    (work / "elsewhere").write_bytes(whole)
    render(work, "link", env, warnings=1, says=["damaged"])
    check(not victim.is_symlink() and (work / "elsewhere").read_bytes() == whole)
    victim.chmod(0o666)
    render(work, "open to others", env, warnings=1, says=["others may write it"])
    check(mode(victim) == 0o600)


def others(work, env, store, kept, digest):
    """A folder that others may write is not trusted; one of another user's is not touched."""
    store.chmod(0o777)
    check(render(work, "open", env, warnings=1, says=["open for others to write", "emptied"])[0] == digest)
    check(mode(store) == 0o700 and len(kept_in(store)) == len(kept))
    if os.geteuid() == 0:
        os.chown(store, 12345, 12345)
        before = kept_in(store)
        check(
            render(work, "foreign", env, warnings=1, says=["belongs to user 12345", "not kept", "XDG_CACHE_HOME"])[0]
            == digest
        )
        check(kept_in(store) == before and list((work / "tmp").iterdir()) == [])
        os.chown(store, 0, 0)


def no_home(work, digest):
    """Without a home, or with one that may not be written: a private folder that goes, and nothing of a known name in a
    shared place."""
    before = {place: place.exists() for place in SHARED_PLACES}
    file = work / "file"
    file.write_text("")
    homes = (
        ("no home", environment(work), "neither XDG_CACHE_HOME nor HOME is set"),
        ("unwritable home", environment(work, HOME="/proc/self"), "/proc/self/.cache/raycube/kernels"),
        ("file for a home", environment(work, HOME=file), f"{file}/.cache"),
    )
    for name, env, says in homes if FULL else homes[:1]:
        check(render(work, name, env, warnings=1, says=[says, "not kept"])[0] == digest)
        check(list((work / "tmp").iterdir()) == [], name)
    check({place: place.exists() for place in SHARED_PLACES} == before)
    render(
        work,
        "no place",
        {**environment(work), "TMPDIR": "/proc/self/fd"},
        status=3,
        says=["no place for compiled kernels", "TMPDIR"],
    )
    own = work / "pocl"  # which the first render filled
    check(render(work, "user's", environment(work, POCL_CACHE_DIR=own))[0] == digest)  # left to the driver
    check(any(own.rglob("*.so")) and not any(own.rglob("*.kernels")))


def sweep(work, env, store, kept):
    """What was not used for long goes, the oldest of too much goes, and so does what a killed run left; a run's that
    lives stays."""
    old, big, left = (
        store / ("0" * 64 + ".kernels"),
        [store / (f"{i}" * 64 + ".kernels") for i in range(1, 4)],
        store / "run-killed",
    )
    old.write_bytes(b"x")
    os.utime(old, (time.time() - 100 * 86400,) * 2)
    for age, path in enumerate(big):
        with open(path, "wb") as file:
            file.truncate(100 << 20)
        os.utime(path, (time.time() - 86400 * (age + 1),) * 2)
    left.mkdir()
    (left / "program.bc").write_bytes(b"x")
    living = store / "run-living"
    living.mkdir()
    for folder in (left, living):
        os.utime(folder, (time.time() - 3600,) * 2)
    lock = os.open(living, os.O_RDONLY)
    fcntl.flock(lock, fcntl.LOCK_EX)  # as a living run holds it
    render(work, "swept", env)
    os.close(lock)
    check(
        not old.exists()
        and [path.exists() for path in big] == [True, True, False]
        and not left.exists()
        and living.exists()
    )
    check(all(path.exists() for path in kept))
    for path in big:
        path.unlink(missing_ok=True)


def full_disk(work, digest):
    """No room for kernels: one error of the environment, before anything is built or when the compiler gives up."""
    env = environment(work, XDG_CACHE_HOME=work / "small")
    (work / "small").mkdir()

    for limit in (8 << 10, 24 << 10, 100 << 10):  # the program, the first kernel, a later one do not fit

        def short_files():
            signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
            resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit))

        done = patience.run(
            [program.path, "render", work / "tiny.toml", "-o", work / "out/short"],
            env=env,
            capture_output=True,
            text=True,
            preexec_fn=short_files,
        )
        check(
            done.returncode == 3 and done.stderr.count("raycube: error: ") == 1 and "ree some space" in done.stderr,
            limit,
            done,
        )
        check(not list((work / "out/short").rglob("radiance*")), done)
    script = f'mount -t tmpfs -o size=1m none {work}/small || exit 99; exec "$0" "$@"'
    mount = ["unshare", "-m", "mount", "-t", "tmpfs", "none", work / "small"]
    if patience.run(mount, capture_output=True).returncode == 0:
        done = patience.run(
            ["unshare", "-m", "sh", "-c", script, program.path, "render", work / "tiny.toml", "-o", work / "out/full"],
            env=env,
            capture_output=True,
            text=True,
        )
        check(done.returncode == 3 and done.stderr.count("raycube: error: ") == 1, done)
        check("no room for compiled kernels" in done.stderr and "XDG_CACHE_HOME" in done.stderr, done.stderr)
    else:
        print("kernel cache: SKIPPED the full disk: mounts need root and CAP_SYS_ADMIN", flush=True)


def full_with_sound_archives(work, env, store, digest):
    """What was kept does not fit where the driver looks: one error of the environment, and nothing that is sound goes
    or is called damaged."""
    before = {path: path.read_bytes() for path in kept_in(store)}
    for limit in (4 << 10, 20 << 10, 60 << 10):
        err = render(
            work,
            "no room for kept",
            env,
            status=3,
            says=["ree some space"],
            preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit)),
        )[1]
        check("damaged" not in err and {path: path.read_bytes() for path in kept_in(store)} == before, limit, err)
        check(sorted(store.iterdir()) == sorted(before), list(store.iterdir()))
    check(render(work, "room again", env)[0] == digest)


def unpacked(archive):
    """Files by path (host/cl/kernel_archive.h)."""
    at, files = 80, {}
    for _ in range(int.from_bytes(archive[72:80], "little")):
        path, content = (int.from_bytes(archive[at + 8 * i : at + 8 * i + 8], "little") for i in (0, 1))
        at += 16
        files[archive[at : at + path].decode()] = archive[at + path : at + path + content]
        at += path + content
    return files


def packed(stem, files):
    out = b"RCKERN1\n" + stem.encode() + len(files).to_bytes(8, "little")
    for path, content in files.items():
        out += len(path.encode()).to_bytes(8, "little") + len(content).to_bytes(8, "little") + path.encode() + content
    return out + hashlib.sha256(out).hexdigest().encode()


def names(files):
    """Without the driver's folder, whose name stands for the intermediate code: that names a file of the run."""
    return {path.split("/", 2)[-1] for path in files}


def of_another_driver(work, env, store, digest):
    """Kept by a driver that looked elsewhere: compiled anew, and what no driver here looks for is not carried along for
    ever."""
    victim = min(kept_in(store), key=lambda path: path.stat().st_size)
    files = unpacked(victim.read_bytes())
    check(packed(victim.stem, files) == victim.read_bytes() and files)
    victim.write_bytes(
        packed(victim.stem, {"ZZ/dead" + path[path.index("/", 3) :]: content for path, content in files.items()})
    )
    check(render(work, "other driver", env)[0] == digest)
    check(set(unpacked(victim.read_bytes())) == set(files), set(unpacked(victim.read_bytes())))


def sound_but_useless(work, env, store, digest):
    """Whole by its checksum and of no use here: one warning with the reason, compiled anew, nothing outside the folder,
    whole again."""
    victim = min(kept_in(store), key=lambda path: path.stat().st_size)
    sound = unpacked(victim.read_bytes())
    first = next(iter(sound))
    outside = store.parent / "escaped"
    for name, files, says in (
        (
            "too long a name",
            {first: b"x", first + "/" + "n" * 300: b"x"},
            ["cannot be used by this run", "compiled anew"],
        ),
        ("no folder of the driver's", {"ZZ/" + "n" * 300: b"x", **sound}, ["cannot be used by this run"]),
        ("a name that climbs", {"../../escaped": b"x"}, ["damaged", "names a file outside its folder"]),
        ("a name from the root", {str(outside): b"x"}, ["damaged", "names a file outside its folder"]),
    ):
        victim.write_bytes(packed(victim.stem, files))
        check(render(work, name, env, warnings=1, says=[str(victim), *says])[0] == digest)
        check(not outside.exists() and not (store / "escaped").exists(), name)
        check(names(unpacked(victim.read_bytes())) == names(sound), name, set(unpacked(victim.read_bytes())))
        check(render(work, name, env)[0] == digest)  # and without a word the next time
    # A folder in its place can be neither read nor replaced: said twice, and the render stands.
    whole = victim.read_bytes()
    victim.unlink()
    (victim / "full").mkdir(parents=True)
    render(work, "a folder", env, warnings=2, says=[str(victim), "damaged", "could not be kept for the next run"])
    shutil.rmtree(victim)
    victim.write_bytes(whole)
    victim.chmod(0o600)


def healed_by_a_render(work):
    """The program itself, whose kernels are the usual cache's: it finds them, and heals what is damaged of them."""
    env = environment(work, XDG_CACHE_HOME=own_cache(work / "usual"))
    program.run("render", work / "tiny.toml", "-o", work / "out/first", env=env)  # compiles where nothing was kept yet
    digest = record(work / "out/first/camera")["digest"]
    store = work / "usual/cache/raycube/kernels"
    asked = work / "asked.tsv"
    check(render(work, "second", {**env, "RAYCUBE_PROGRAM_LOG": str(asked)}, whole=True)[0] == digest)
    programs = [line.split("\t") for line in asked.read_text().splitlines()]
    check(len(programs) >= 2 and {how for _, _, how, _ in programs} == {"kept"}, programs)
    victim = min((store / f"{key}.kernels" for _, key, _, _ in programs), key=lambda path: path.stat().st_size)
    content = victim.read_bytes()
    victim.unlink()  # the usual cache's file may be this one
    victim.write_bytes(content[: len(content) // 2])
    says = [str(victim), "damaged", "compiled anew"]
    check(render(work, "healed", env, warnings=1, says=says, whole=True)[0] == digest)
    check(victim.stat().st_size > len(content) // 2)


def came_with_the_program(work):
    """A first render of `raycube new`'s scene finds every kernel compiled with the program, and keeps none itself. One
    that is damaged, or that others may write, is compiled anew and left as it is."""
    data = pathlib.Path(program.path).parent / "share/raycube"
    program.run("new", work / "garden")

    def first_render(name, data, warnings=0, says=()):
        log = work / "first.tsv"
        log.unlink(missing_ok=True)
        env = environment(work, XDG_CACHE_HOME=work / "first", RAYCUBE_DATA=data, RAYCUBE_PROGRAM_LOG=log)
        out = work / "first renders" / name
        command = [program.path, "render", work / "garden/garden.toml", "-o", out]
        done = patience.run(command, env=env, capture_output=True, text=True)
        check(done.returncode == 0 and done.stderr.count("raycube: warning: ") == warnings, name, done.stderr)
        for part in says:
            check(part in done.stderr, name, part, done.stderr)
        asked = [line.split("\t")[1:3] for line in log.read_text().splitlines()]
        compiled = {key for key, how in asked if how == "compiled"}
        return record(out / "camera")["digest"], {key for key, _ in asked}, compiled

    store = work / "first/raycube/kernels"
    digest, programs, compiled = first_render("installed", data)
    check(len(programs) >= 3 and not compiled and not kept_in(store), programs, compiled, kept_in(store))
    own = work / "installation"
    shutil.copytree(data / "kernels", own / "kernels")
    victim = min((own / "kernels" / f"{key}.kernels" for key in programs), key=lambda path: path.stat().st_size)
    sound = victim.read_bytes()
    cut = sound[: len(sound) // 2]
    victim.write_bytes(cut)
    says = [str(victim), "damaged", "compiled anew"]
    check(first_render("cut short", own, warnings=1, says=says) == (digest, programs, {victim.stem}))
    healed = store / victim.name
    check(victim.read_bytes() == cut and kept_in(store) == [healed])
    check(first_render("healed", own) == (digest, programs, set()))
    victim.write_bytes(sound)
    healed.write_bytes(cut)
    says = [str(healed), "damaged", "those that came with the program are taken"]
    check(first_render("user's cut short", own, warnings=1, says=says) == (digest, programs, set()))
    check(kept_in(store) == [])
    victim.chmod(0o646)
    says = [str(victim), "others may write it", "compiled anew"]
    check(first_render("open to others", own, warnings=1, says=says) == (digest, programs, {victim.stem}))


def at_once(work, digest):
    """Two runs that find an empty cache at the same time."""
    env = environment(work, XDG_CACHE_HOME=work / "together")
    runs = [program.start("render", work / "tiny.toml", "-o", work / f"out/together{i}", env=env) for i in range(2)]
    for i, run in enumerate(runs):
        err = patience.end_of(run)[1]
        check(run.returncode == 0 and "warning" not in err, err)
        check(record(work / f"out/together{i}/camera")["digest"] == digest)
    names = sorted((work / "together/raycube/kernels").iterdir())
    check(names and all(path.suffix == ".kernels" for path in names), names)


with tempfile.TemporaryDirectory() as folder:
    work = pathlib.Path(folder)
    scene(work, "tiny.toml")
    digest = render(work, "driver's", environment(work, POCL_CACHE_DIR=work / "pocl"))[0]
    if not any((work / "pocl").rglob("*.so")):
        print("kernel cache: SKIPPED: this OpenCL driver is not PoCL", flush=True)
        sys.exit(77)
    env, store, kept = home_of_its_own(work, digest)
    damage(work, env, store, kept, digest)
    no_home(work, digest)
    if FULL:
        others(work, env, store, kept, digest)
        full_with_sound_archives(work, env, store, digest)
        of_another_driver(work, env, store, digest)
        sound_but_useless(work, env, store, digest)
        sweep(work, env, store, kept)
        full_disk(work, digest)
        at_once(work, digest)
    else:
        healed_by_a_render(work)
        came_with_the_program(work)
print(f"kernel cache: {program.checks} checks")
