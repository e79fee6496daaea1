"""What the tests that drive the program share: runs, checks, small scenes, an ENVI reader that owes ours nothing."""

import json
import os
import pathlib
import shutil
import signal
import struct
import subprocess
import sys
import tempfile

import numpy

import patience

#: All cases of a test, as ci/test --full asks for; else those of its short form, which the test's head names.
FULL = "--full" in sys.argv

#: Whether what one verb refuses is tried with all others that refuse it (ci/test --full), or with one of them.
EVERY_VERB = FULL or bool(os.environ.get("RAYCUBE_TEST_EVERY_VERB"))

#: tests/repeat_seeds.py: which other draws a test is to take, and the file that its figures go into.
OTHER_SEED, FIGURES = os.environ.get("RAYCUBE_TEST_SEED"), os.environ.get("RAYCUBE_TEST_FIGURES")


def seed(own):
    """A test's own seed; with RAYCUBE_TEST_SEED = 1, 2, .. another one (tests/support/seeds.h)."""
    return own + 1000003 * int(OTHER_SEED) if OTHER_SEED else own


def by_other_seed(arguments):
    """A command line whose verb draws, with the seed that stands in for its own or the scene's."""
    if not OTHER_SEED or arguments[0] not in ("render", "check", "measure", "noise", "preview", "plan"):
        return arguments
    if "--seed" not in arguments:
        return (*arguments, "--seed", str(seed(1)))
    at = arguments.index("--seed") + 1
    return (*arguments[:at], str(seed(int(arguments[at]))), *arguments[at + 1 :])


#: Level ground under a LIDAR: its material and its plane.
GROUND = """[[material]]
name = "ground"
reflectance = 0.3
[[plane]]
material = "ground"
size_m = [200.0, 200.0]
"""


def pulse_and_receiver(energy_J="1e-4", divergence_mrad=0.2, fov_mrad=2.0):
    """Laser and telescope of a survey, to follow the head of a [[lidar]]."""
    return f"""[lidar.pulse]
energy_J = {energy_J}
wavelength_nm = 1064.0
fwhm_ns = 4.0
divergence_mrad = {divergence_mrad}
divergence_is = "full angle at 1/e^2"
[lidar.receiver]
aperture_diameter_m = 0.1
fov_mrad = {fov_mrad}
"""


PULSE_AND_RECEIVER = pulse_and_receiver()


def gate(start_m, stop_m, subrays=16):
    """Gate and sub-rays of a survey; further keys of [lidar.sampling] may follow."""
    return f"""[lidar.gate]
start_range_m = {start_m}
stop_range_m = {stop_m}
[lidar.sampling]
subrays = {subrays}
"""


kTypes = {1: "u1", 2: "i2", 3: "i4", 4: "f4", 5: "f8", 12: "u2", 13: "u4"}


def _bring(source, target):
    """Kept kernels of one folder, into another that lacks them or has fewer."""
    for file in source.glob("*.kernels"):
        at, new = target / file.name, target / f".{file.name}-{os.getpid()}"
        try:
            if at.exists() and at.stat().st_size >= file.stat().st_size:
                continue
            try:
                os.link(file, new)
            except OSError:  # another file system
                shutil.copy2(file, new)
            os.replace(new, at)
        except FileNotFoundError:  # swept meanwhile, by a run beside this one
            continue


_apart = []


def own_cache(folder):
    """An XDG_CACHE_HOME inside FOLDER, for runs that find neither tables nor references kept. Compiled kernels are the
    usual cache's, and new ones go back there: a test that compiled them for itself would do little else."""
    usual = pathlib.Path(os.environ.get("XDG_CACHE_HOME") or pathlib.Path.home() / ".cache") / "raycube/kernels"
    own = pathlib.Path(folder) / "cache/raycube/kernels"
    for made in (usual, own):
        made.mkdir(mode=0o700, parents=True, exist_ok=True)
    _bring(usual, own)
    _apart.append((own, usual))
    return str(pathlib.Path(folder) / "cache")


OF_MEASURES = ("raycube: error: measure '", "raycube: error: budget '")  # of sun, bands and edge; renders take none


def _errors(stderr):
    """What is refused, whatever the order."""
    lines = {line for line in stderr.splitlines() if line.startswith("raycube: error: ")}
    return {line for line in lines if "no [[instrument]] or [[lidar]] looks at the scene" not in line}


def _content(folder):
    """What tells a folder's files from others': names, sizes, and what small ones hold."""
    out = []
    for path in sorted(folder.rglob("*")):
        if path.is_file() and not path.is_symlink():
            small = path.stat().st_size < 1 << 20
            out.append((str(path), path.stat().st_size, hash(path.read_bytes()) if small else path.stat().st_mtime_ns))
    return tuple(out)


class Program:
    """The raycube under test; counts what was checked."""

    def __init__(self, path):
        self.path = str(pathlib.Path(path).resolve())
        self.checks = 0
        self._alike = set()  # scenes that all four verbs were seen to refuse

    def run(self, *arguments, status=0, env=None, **more):
        done = patience.run(
            [self.path, *by_other_seed(arguments)],
            capture_output=True,
            text=True,
            env={**os.environ, **(env or {})},
            **more,
        )
        for own, usual in _apart:
            _bring(own, usual)
        assert (
            done.returncode == status
        ), f"{arguments}: status {done.returncode}, not {status}\n{done.stdout}{done.stderr}"
        if status == 2 and env is None and more.keys() <= {"cwd"}:
            self._refused_alike([*map(str, arguments)], done.stderr, more)
        return done

    def _refused_alike(self, arguments, stderr, more):
        """What one of `scene check`, `plan`, `render --dry-run` and `render` refuses of a scene they all refuse, in the
        same words, and before a kernel is compiled for it. (A scene that nothing looks at can be checked.) Without
        --full one of the three others, the next in turn, stands for them. What `measure` refuses of a scene `scene
        check` refuses, in the same words beside what it says of instruments; renders take no measures."""
        verb = arguments[:2] if arguments[0] == "scene" else arguments[:1]
        words, settings, files = arguments[len(verb) :], [], []
        while words:
            word = words.pop(0)
            if word == "--set":
                settings += [word, words.pop(0)]
            elif word in ("-o", "--name"):
                words.pop(0)
            elif word not in ("-q", "--dry-run", "--json", "--overwrite"):
                files.append(word)
        errors = _errors(stderr)
        at = pathlib.Path(more.get("cwd", "."), files[0] if files else "")
        if verb not in (["scene", "check"], ["plan"], ["render"], ["measure"]) or len(files) != 1 or not at.is_file():
            return
        measure = verb == ["measure"]
        rendered = {line for line in errors if not line.startswith(OF_MEASURES)}
        if not rendered and not measure:  # of measures alone, by `scene check`
            return
        if any("--overwrite" in line or "-o" in line.split() for line in errors):  # of the place, not of the scene
            return
        if any("no [[measure]] or" in line or "no measure or budget" in line for line in errors):  # asked for
            return
        state = (tuple(settings), _content(at.parent))
        if state in self._alike:
            return
        self._alike.add(state)
        with tempfile.TemporaryDirectory() as folder:
            log = pathlib.Path(folder) / "programs"
            verbs = (["scene", "check"], ["plan"], ["render", "--dry-run"], ["render", "-o", f"{folder}/out"])
            others = [
                other
                for other in verbs
                if other[: len(verb)] != verb or ("--dry-run" in other) != ("--dry-run" in arguments)
            ]
            others = verbs[:1] if measure else others if EVERY_VERB else others[len(self._alike) % 3 :][:1]
            for other in others:
                environment = {**os.environ, "RAYCUBE_PROGRAM_LOG": str(log)}
                command = [self.path, *by_other_seed((*other, files[0], *settings))]
                done = patience.run(command, capture_output=True, text=True, env=environment, **more)
                self.check(done.returncode == 2, "only", verb, "refuses", files, other, errors, done.stderr)
                found = _errors(done.stderr)
                if measure:
                    self.check(errors <= found, verb, other, errors, done.stderr)
                else:
                    told = {line for line in found if not line.startswith(OF_MEASURES)}
                    self.check(told == rendered, verb, other, errors, done.stderr)
            self.check(not log.exists(), "kernels compiled for what is refused", arguments, errors)

    def start(self, *arguments, env=None, **more):
        return subprocess.Popen(
            [self.path, *map(str, arguments)],
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            env={**os.environ, **(env or {})},
            **more,
        )

    def start_listening(self, *arguments, env=None):
        """Started, and so far that SIGINT reaches the program's own handler: a signal that comes while its libraries
        are still loaded ends it as any program."""
        process = self.start(*arguments, env=env)
        patience.until(
            lambda: process.poll() is not None
            or int(patience.status_of(process.pid, "SigCgt") or "0", 16) >> (signal.SIGINT - 1) & 1,
            "the program's handler of SIGINT",
        )
        return process

    def mid_write(self, written, *arguments, **more):
        """A run that has written something into a file that `written`, a folder and a pattern, matches, and is halted
        there: however fast the machine, it lives and has not ended when what comes next is done to it."""
        process = self.start(*arguments, **more)
        patience.until(lambda: _has_content(*written), f"the first bytes of {'/'.join(map(str, written))}", process)
        assert patience.halted(process).poll() is None, (process.args, "ended before it was halted", process.returncode)
        return process

    def mid_render(self, file, out, **more):
        """A render in the middle of its cube, halted; `file` is one that goes on for long."""
        arguments = ("render", file, "-o", out, "--memory", "32M", "-q")
        return self.mid_write((out / "camera", ".radiance.img.*"), *arguments, **more)

    def check(self, condition, *what):
        self.checks += 1
        assert condition, what

    def between(self, low, figure, high, *what):
        """A check of a figure that chance moves: the line that asks for it, and `what`, name it in FIGURES."""
        if FIGURES:
            caller = sys._getframe(1)
            while caller.f_code.co_name in ("near", "is_near", "within"):
                caller = caller.f_back
            named = " ".join(part for part in what if isinstance(part, str))
            with open(FIGURES, "a") as file:
                at = f"{caller.f_code.co_filename}:{caller.f_lineno}"
                file.write(f"{at}\t{named}\t{figure}\t{low}\t{high}\n")
        self.check(low <= figure <= high, *what, low, figure, high)

    def within(self, figure, limit, *what):
        self.between(-limit, figure, limit, *what)

    def refused(self, *arguments, status, says, messages=1, env=None, **more):
        """Exactly `messages` error lines, each part of `says` in them, nothing on stdout. Not asked again with other
        seeds, which no refusal depends on."""
        if OTHER_SEED:
            return None
        done = self.run(*arguments, status=status, env=env, **more)
        lines = [line for line in done.stderr.splitlines() if line.startswith("raycube: error: ")]
        self.check(len(lines) == messages and done.stdout == "", done.stderr, done.stdout)
        for part in says:
            self.check(part in done.stderr, part, done.stderr)
        return done


def _has_content(folder, pattern):
    try:
        return any(path.stat().st_size > 0 for path in folder.glob(pattern) if path.is_file())
    except OSError:  # gone meanwhile
        return False


def camera(pixels, lines, grid, first_nm, step_nm=10, count=1, fwhm_nm=10):
    """A framing camera that looks down from 500 m onto pixels of 1 m."""
    return f"""[[instrument]]
name = "camera"
kind = "framing"
pixels = {pixels}
lines = {lines}
position_m = [0, 0, 500]
ifov_mrad = 2
samples = {{ grid = [{grid}, {grid}] }}
bands = {{ first_nm = {first_nm}, step_nm = {step_nm}, count = {count}, fwhm_nm = {fwhm_nm} }}
"""


def options(**values):
    """Options of the command line: sun_zenith=50 is --sun-zenith 50."""
    return [part for name, value in values.items() for part in ("--" + name.replace("_", "-"), value)]


def header_of(path):
    """An ENVI header as a dictionary of text; lists are split at commas."""
    text = pathlib.Path(path).read_text()
    assert text.startswith("ENVI\n") and "\t" not in text and text.count("{") == text.count("}")
    out, rest = {}, text[5:]
    while "=" in rest:
        key, _, rest = rest.partition("=")
        if rest.lstrip().startswith("{"):
            value, _, rest = rest.lstrip()[1:].partition("}")
            value = value.strip() if key.strip() == "description" else [part.strip() for part in value.split(",")]
        else:
            value, _, rest = rest.partition("\n")
            value = value.strip()
        out[key.strip()] = value
    return out


def envi(folder, name):
    """(header, array [line][sample][band]) of folder/name.img; asserts that header and file size agree."""
    header = header_of(pathlib.Path(folder) / (name + ".hdr"))
    data = numpy.fromfile(
        pathlib.Path(folder) / (name + ".img"),
        dtype=numpy.dtype(kTypes[int(header["data type"])]).newbyteorder("<>"[int(header["byte order"])]),
    )
    lines, samples, bands = (int(header[key]) for key in ("lines", "samples", "bands"))
    assert data.size == lines * samples * bands, (data.size, header)
    if header["interleave"] == "bip":
        return header, data.reshape(lines, samples, bands)
    if header["interleave"] == "bil":
        return header, data.reshape(lines, bands, samples).transpose(0, 2, 1)
    assert header["interleave"] == "bsq", header
    return header, data.reshape(bands, lines, samples).transpose(1, 2, 0)


def float_image(path, values):
    """[row][column] or [row][column][band], as ENVI."""
    values = values.reshape(values.shape[0], values.shape[1], -1)
    values.astype("<f4").tofile(path)
    pathlib.Path(str(path) + ".hdr").write_text(
        f"ENVI\nsamples = {values.shape[1]}\nlines = {values.shape[0]}\nbands = {values.shape[2]}\nheader offset = 0\n"
        "file type = ENVI Standard\ndata type = 4\ninterleave = bip\nbyte order = 0\n"
    )


def tiff(path, values, orientation=1, place=None):
    """An uncompressed picture of eight bits with an orientation, and a place on a map: (easting, northing) of its
    corner and the side of its pixels."""
    rows, columns = values.shape
    doubles = [place[2], place[2], 0.0, 0.0, 0.0, 0.0, place[0], place[1], 0.0] if place else []
    keys = [1, 1, 0, 2, 1024, 0, 1, 1, 3072, 0, 1, 32632] if place else []
    entries = [(256, 3, 1, columns), (257, 3, 1, rows), (258, 3, 1, 8), (259, 3, 1, 1), (262, 3, 1, 1)]
    entries += [(273, 4, 1, 8), (274, 3, 1, orientation), (277, 3, 1, 1), (278, 3, 1, rows), (279, 4, 1, values.size)]
    at = 8 + values.size + values.size % 2
    if place:
        entries += [(33550, 12, 3, at), (33922, 12, 6, at + 24), (34735, 3, len(keys), at + 72)]
    extra = struct.pack(f"<{len(doubles)}d{len(keys)}H", *doubles, *keys)
    directory = struct.pack("<H", len(entries)) + b"".join(struct.pack("<HHII", *entry) for entry in entries)
    pixels = values.astype("u1").tobytes() + b"\0" * (values.size % 2)
    path.write_bytes(struct.pack("<2sHI", b"II", 42, at + len(extra)) + pixels + extra + directory + b"\0" * 4)


def record(folder):
    return json.loads((pathlib.Path(folder) / "run.json").read_text())


def plate(folder, head, *, agl_m, lines, grid, pitch_deg=0, size_m=4000.0, height_m=0.0, reflectance=0.3):
    """plane.toml: a grey plate that fills the view of a camera in air, whose bands are those of bands.csv."""
    path = pathlib.Path(folder) / "plane.toml"
    path.write_text(f"""format = 1
{head}
material = [ {{ name = "grey", reflectance = {reflectance} }} ]
plane = [ {{ material = "grey", position_m = [0.0, 0.0, {height_m}], size_m = [{size_m}, {size_m}] }} ]
[[instrument]]
name = "camera"
kind = "framing"
position_m = [0.0, 0.0, {agl_m}]
pitch_deg = {pitch_deg}
ifov_mrad = 1.0
pixels = 4
lines = {lines}
samples = {{ grid = [{grid}, {grid}] }}
bands = {{ file = "bands.csv" }}
""")
    return path


def scene(folder, name, *, head="bounces = 0", air='{ model = "none" }', pixels=24, lines=12, grid=3, instrument=""):
    """Three grey strips (0.10, 0.45, 0.80) of 10 m side by side from west to east under the sun, seen from 500 m at 1
    m."""
    path = pathlib.Path(folder) / name
    path.write_text(f"""format = 1
{head}
material = [
  {{ name = "dark", reflectance = 0.10 }},
  {{ name = "middle", reflectance = 0.45 }},
  {{ name = "light", reflectance = 0.80 }},
]
plane = [
  {{ material = "dark", position_m = [-10.0, 0.0, 0.0], size_m = [10.0, 40.0] }},
  {{ material = "middle", size_m = [10.0, 40.0] }},
  {{ material = "light", position_m = [10.0, 0.0, 0.0], size_m = [10.0, 40.0] }},
]
atmosphere = {air}
time = {{ sun = {{ zenith_deg = 40.0, azimuth_deg = 150.0 }} }}
[[instrument]]
name = "camera"
kind = "framing"
altitude_agl_m = 500.0
gsd_m = 1.0
pixels = {pixels}
lines = {lines}
samples = {{ grid = [{grid}, {grid}] }}
bands = {{ first_nm = 450.0, step_nm = 50.0, count = 10, fwhm_nm = 20.0 }}
{instrument}
""")
    return path
