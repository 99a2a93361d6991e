#!/usr/bin/env bash
# The test command: installs what is missing, builds, runs every test, ends with "N passed, N failed, N skipped".
#
#   tests/run.sh            g++, optimised
#   tests/run.sh clang      the second compiler
#   tests/run.sh sanitize   address and undefined-behaviour sanitizers: 45 minutes on real models
#   tests/run.sh tsan       the thread sanitizer
#
# Tests on real models read the folder that MVW_MODELS names and are skipped (and counted) where it is unset.
set -euo pipefail
cd "$(dirname "$0")/.."
preset="${1:-default}"
case "$preset" in
    default) folder=build ;;
    clang | sanitize | tsan) folder="build-$preset" ;;
    *) echo "usage: tests/run.sh [default|clang|sanitize|tsan]" >&2; exit 2 ;;
esac

tools/setup.sh
cmake --preset "$preset"
cmake --build --preset "$preset"

if [ "$preset" = sanitize ]; then
    export MVW_TEST_SECONDS=3000
    # What Mesa, LLVM and Embree keep for the life of a process is not ours to free.
    export LSAN_OPTIONS="suppressions=$PWD/tests/leaks_of_libraries.txt:print_suppressions=0"
    export UBSAN_OPTIONS="print_stacktrace=1"
fi
if [ "$preset" = tsan ]; then
    export MVW_TEST_SECONDS=3000
    export TSAN_OPTIONS="halt_on_error=1:second_deadlock_stack=1:suppressions=$PWD/tests/races_of_libraries.txt"
fi
javascript=()
if [ "$preset" = default ]; then
    # The browser's decoder and page, and what drives them.
    client/web/build.sh "$folder"
    [ -d tests/client/web/node_modules ] || npm ci --prefix tests/client/web --no-audit --no-fund
    javascript=(tests/client/web)
fi
exec python3 tests/run_tests.py "$folder/mvw_tests" "${javascript[@]}"
