#!/bin/sh
# `raycube scene` as users drive it: $1 the program, $2 the folder scenes/, $3 an empty work folder.
set -u
raycube=$1 scenes=$2 work=$3
rm -rf "$work" && mkdir -p "$work"
fail() { echo "FAILED: $1"; exit 1; }

"$raycube" scene check "$scenes/panels/panels.toml" >"$work/check" 2>&1 || fail "check of a sound file ended with $?"
grep -q 'sound; 1 instrument, 0 LIDARs, 0 notices' "$work/check" || fail "check said: $(cat "$work/check")"

# The compiled file holds what the simulation file gives: same content hash, same counts.
"$raycube" scene info "$scenes/panels/panels.toml" >"$work/from_toml" || fail "info of a simulation file"
"$raycube" scene compile "$scenes/panels/panels.toml" -o "$work/p.rcs" >"$work/from_compile" || fail "compile"
"$raycube" scene info "$work/p.rcs" >"$work/from_rcs" || fail "info of a compiled file"
cmp "$work/from_toml" "$work/from_rcs" || fail "info differs between simulation and compiled file"
grep -q '^content *[0-9a-f]\{64\}$' "$work/from_rcs" || fail "info shows no content hash"
grep -q '6 stored, 6 placed by 3 instances' "$work/from_rcs" || fail "three panels are 6 triangles in 3 instances"

# Nothing is overwritten unless asked for.
"$raycube" scene compile "$scenes/panels/panels.toml" -o "$work/p.rcs" >/dev/null 2>&1
[ $? -eq 2 ] || fail "overwriting must be refused with status 2"
"$raycube" scene compile "$scenes/panels/panels.toml" -o "$work/p.rcs" --overwrite >/dev/null 2>&1 || fail "--overwrite"

# Bad input: status 2, every problem with its place.
printf 'format = 1\ntolerence = 0.1\nseed = -1\n' >"$work/bad.toml"
"$raycube" scene check "$work/bad.toml" >"$work/out" 2>"$work/err"
[ $? -eq 2 ] || fail "bad input must end with status 2"
grep -q "bad.toml:2:1: unknown key at top level (found 'tolerence'); did you mean 'tolerance'?" "$work/err" ||
  fail "$(cat "$work/err")"
grep -q "bad.toml:3:8: 'seed' is out of range (found -1)" "$work/err" || fail "$(cat "$work/err")"
[ ! -s "$work/out" ] || fail "errors belong on stderr"
head -c 200 "$work/p.rcs" >"$work/cut.rcs"
"$raycube" scene info "$work/cut.rcs" >/dev/null 2>"$work/err"
[ $? -eq 2 ] || fail "a truncated .rcs must end with status 2"
grep -q 'cut.rcs: compiled scene is damaged' "$work/err" || fail "$(cat "$work/err")"

"$raycube" scene schema | grep -q '"additionalProperties": false' || fail "schema"
"$raycube" scene keys | grep -q '^| `altitude_agl_m` | number | m |' || fail "keys"
echo "scene verb: all as it should be"
