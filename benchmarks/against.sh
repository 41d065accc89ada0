#!/usr/bin/env bash
# Compare the speed of this tree with that of a release: benchmarks/against.sh v0.1.0
#
# Both are measured now, on this machine: numbers of another day or computer tell nothing. The release is checked out
# into a folder of its own and measured by this tree's benchmarks. Times are kept in benchmarks/history/, a file per
# commit. Fails if a time grew by more than a quarter. Leave the machine alone meanwhile: with other work on its cores,
# the same code has differed by 30 %.
set -euo pipefail
cd "$(dirname "$0")/.."
base=${1:-}
[ -n "$base" ] || { echo "there is no tag yet; name a commit: make bench BASE=COMMIT"; exit 1; }

folder=$(mktemp -d)
trap 'git worktree remove --force "$folder/base" 2>/dev/null || true; rm -rf "$folder"' EXIT
git worktree add -q --detach "$folder/base" "$base"

measure() { # name, source tree, further options; -P: the folder we stand in is not imported from
    name=$1 tree=$2
    shift 2
    MEASURED=$name PYTHONPATH=$tree OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1 python -P -m pytest -q benchmarks/test_speed.py \
        -p no:cacheprovider --benchmark-storage=file://benchmarks/history --benchmark-save="$name" \
        --benchmark-columns=min,median,rounds --benchmark-timer=time.process_time "$@"
}

measure "$(git describe --always "$base")" "$folder/base"
measure "$(git describe --always --dirty)" "$PWD" --benchmark-compare --benchmark-compare-fail=min:25%
