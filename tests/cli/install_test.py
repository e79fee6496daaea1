#!/usr/bin/env python3
"""An installation can be moved: install to one prefix, move it, run it there from another folder without the build
tree's data; then the Debian package. usage: install_test.py BUILD_DIR CMAKE [CPACK]"""

import json
import os
import pathlib
import re
import sys
import tempfile

import patience

build, cmake = pathlib.Path(sys.argv[1]).resolve(), sys.argv[2]
environment = {k: v for k, v in os.environ.items() if k != "RAYCUBE_DATA"}


def run(*command, status=0, **more):
    done = patience.run(
        [str(c) for c in command], capture_output=True, text=True, env=more.pop("env", environment), **more
    )
    assert done.returncode == status, f"{command}: status {done.returncode}, not {status}\n{done.stdout}{done.stderr}"
    return done


with tempfile.TemporaryDirectory() as folder:
    folder = pathlib.Path(folder)
    run(cmake, "--install", build, "--prefix", folder / "first")
    prefix = folder / "moved" / "here"
    prefix.parent.mkdir()
    (folder / "first").rename(prefix)
    program = prefix / "bin" / "raycube"
    elsewhere = folder / "elsewhere"
    elsewhere.mkdir()

    assert run(program, "--version", cwd=elsewhere).stdout.startswith("raycube 0.")
    verbs = [v["name"] for v in json.loads(run(program, "--json-usage", cwd=elsewhere).stdout)["verbs"]]
    assert "new" in verbs and "info" in verbs, verbs
    manual = (prefix / "share/man/man1/raycube.1").read_text()
    for verb in verbs:
        assert f".SS {verb}" in manual, verb
    assert "EXIT STATUS" in manual
    # Pages that messages, the man page and the installed pages themselves refer to are installed.
    pages = prefix / "share/doc/raycube"
    named = {name.decode() for name in re.findall(rb"docs/[a-z_]+\.md", program.read_bytes())}
    named.update(re.findall(r"docs/[a-z_]+\.md", manual))
    assert {"docs/scene_format.md", "docs/studies.md"} <= named, named
    for name in sorted(named):
        assert (pages / name).is_file(), f"{name} is named and not installed"
    for page in (pages / "README.md", *(pages / "docs").glob("*.md")):
        for link in re.findall(r"\]\(([^)#:]+\.(?:md|png))(?:#[^)]*)?\)", page.read_text()):
            assert (page.parent / link).is_file(), f"{page.name} refers to {link}, which is not installed"
    assert (prefix / "share/raycube/scenes/park/park.toml").is_file()
    built = sorted(path.name for path in (build / "share/raycube/kernels").glob("*.kernels"))
    installed = prefix / "share/raycube/kernels"
    assert sorted(path.name for path in installed.glob("*")) == built, built  # none where the build had no device
    assert all(path.stat().st_mode & 0o777 == 0o644 for path in installed.glob("*"))

    # `new` needs share/raycube: it must come from the moved prefix, not from the build tree.
    written = json.loads(run(program, "new", "--json", "garden", cwd=elsewhere).stdout)
    assert (elsewhere / written["scene"]).is_file()
    (prefix / "share/raycube").rename(prefix / "share/hidden")
    lost = run(program, "new", "other", cwd=elsewhere, status=3)
    assert "RAYCUBE_DATA" in lost.stderr, lost.stderr
    run(program, "new", "other", cwd=elsewhere, env={**environment, "RAYCUBE_DATA": str(prefix / "share/hidden")})
    # A data folder that lacks a file is an error of the environment and leaves no half scene.
    (prefix / "share/hidden/scenes/starter/tree.obj").unlink()
    run(
        program,
        "new",
        "third",
        cwd=elsewhere,
        status=3,
        env={**environment, "RAYCUBE_DATA": str(prefix / "share/hidden")},
    )
    assert not list((elsewhere / "third").glob("*")), "half a scene was left"

    if len(sys.argv) > 3:
        run(sys.argv[3], "-G", "DEB", "-B", folder / "deb", "--config", build / "CPackConfig.cmake", cwd=folder)
        package = next((folder / "deb").glob("raycube_*.deb"))
        field = lambda name: run("dpkg-deb", "-f", package, name).stdout
        depends = field("Depends")
        # Every library the program names (readelf), or loads, belongs to a package (dpkg -S) that Depends holds.
        sonames = re.findall(r"NEEDED.*\[(.*)\]", run("readelf", "-d", program).stdout)
        paths = dict(re.findall(r"(\S+) => (\S+)", run("ldd", program).stdout))
        assert any(soname.startswith("libOpenCL") for soname in sonames), sonames
        # GDAL is loaded when a raster is read: a program that starts does without its ninety libraries.
        assert not any("gdal" in soname for soname in paths), paths
        loaded = {name.decode() for name in re.findall(rb"libgdal\.so\.\d+", program.read_bytes())}
        assert len(loaded) == 1, loaded
        for soname in [*sonames, *loaded]:
            if soname not in paths and soname not in loaded:
                continue  # the dynamic loader itself
            names = run("dpkg", "-S", "*/" + pathlib.Path(paths.get(soname, soname)).name).stdout
            owners = {line.split(":")[0] for line in names.splitlines()}
            assert any(owner in depends for owner in owners), f"{soname} of {owners} is not in Depends: {depends}"
        assert "pocl-opencl-icd | opencl-icd" in depends, depends
        content = run("dpkg-deb", "-c", package).stdout
        for path in ("/bin/raycube", "/share/man/man1/raycube.1", "/share/raycube/scenes/park/park.toml"):
            assert path in content, path
        print("package:", package.name, "Depends:", depends.strip())
print("install: moved prefix runs, verbs:", " ".join(verbs))
