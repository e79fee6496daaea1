#!/usr/bin/python3
"""The committed figures of gases are what atmos_tables/fit/restate_gases.py makes of the public ones.

Usage: restate_gases_test.py REPOSITORY. Skipped (77), loudly, without RAYCUBE_SHARED.
"""

import os
import pathlib
import sys
import tempfile

import patience

repository = pathlib.Path(sys.argv[1])
shared = os.environ.get("RAYCUBE_SHARED")
if not shared:
    print("SKIPPED: RAYCUBE_SHARED is not set, the figures of gases were not restated anew")
    sys.exit(77)
data = repository / "atmos_tables/gas/data"
with tempfile.TemporaryDirectory() as folder:
    patience.run(
        [
            sys.executable,
            str(repository / "atmos_tables/fit/restate_gases.py"),
            shared + "/reference/atmosphere",
            folder,
        ],
        check=True,
    )
    made = {file.name: file.read_bytes() for file in pathlib.Path(folder).iterdir()}
committed = {file.name: file.read_bytes() for file in data.iterdir()}
if sorted(made) != sorted(committed):
    sys.exit(f"files differ: made {sorted(made)}, committed {sorted(committed)}")
for name in sorted(made):
    old, new = committed[name].splitlines(), made[name].splitlines()
    for line, (was, now) in enumerate(zip(old, new), 1):
        if was != now:
            sys.exit(f"{name}:{line}: committed {was!r}, made {now!r}; run restate_gases.py again")
    if committed[name] != made[name]:
        sys.exit(f"{name}: {len(old)} lines committed, {len(new)} made; run restate_gases.py again")
print(f"{len(made)} files are as committed")
