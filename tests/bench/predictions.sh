#!/usr/bin/env bash
# tests/bench/predictions.sh [LAUNCHER...]
#
# What polyrad check predicts against what polyrad run takes: peak memory [MB] and time [s], as rows
# of a table. Run it from the project's folder, on an idle machine; LAUNCHER is put before every run.
set -euo pipefail

folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
launcher=("$@")

number() { h5dump -a "/polyrad/diagnostics/$1" "$folder/m.h5" | sed -n 's/.*(0): //p'; }

row() { # NAME DECK OPTIONS...
  local name=$1 check
  shift
  check=$("${launcher[@]}" build/release/polyrad check "$@")
  "${launcher[@]}" build/release/polyrad run "$@" --quiet -o "$folder/m.h5"
  printf '| %s | %s | %.0f | %s | %.2f |\n' "$name" \
    "$(sed -n 's/.*holds \([0-9.e+]*\) MB.*/\1/p' <<<"$check")" "$(number peak_memory_bytes | awk '{print $1 / 1e6}')" \
    "$(sed -n 's/.*about \([0-9.e+-]*\) s.*/\1/p' <<<"$check")" "$(number seconds_total)"
}

method() { printf -- '--set method.%s ' "$@"; }

h=matrix=hierarchical
# shellcheck disable=SC2046
{
  s1=(inputs/cube_corner.yml --set 'accuracy={}')
  row 'S1, P(8,1)' "${s1[@]}" $(method elements=8)
  row 'S1, P(8,1), lu' "${s1[@]}" $(method elements=8 solver=lu)
  row 'S1, P(8,1), hierarchical, 1e-10' "${s1[@]}" $(method elements=8 $h)
  row 'S1, P(16,1), hierarchical, 1e-7' "${s1[@]}" $(method elements=16 $h quadrature_tolerance=1e-7)
  row 'S1, P(32,1), hierarchical, 1e-7' "${s1[@]}" $(method elements=32 $h quadrature_tolerance=1e-7)
  row 'S1, P(16,2), hierarchical, 1e-7' "${s1[@]}" $(method elements=16 grading=2 $h quadrature_tolerance=1e-7)
  row 'Cornell box, uniform 4, degree 1' inputs/cornell_box.yml --set 'accuracy={}' $(method mesh=uniform elements=4 degree=1)
  row 'room, constants' inputs/room.yml
  row 'wedge, graded, degree 7' inputs/wedge.yml --set 'accuracy={}' $(method mesh=graded elements=1 degree=7 grading=3)
}
