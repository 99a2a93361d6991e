#!/usr/bin/env bash
# The test command: installs what is missing, builds, runs every test, ends with "N passed, N failed, N skipped".
set -euo pipefail
cd "$(dirname "$0")/.."
tools/setup.sh
cmake --preset default
cmake --build --preset default
set +e
build/mvw_tests --gtest_output=json:build/tests.json
status=$?
set -e
python3 - build/tests.json <<'PY'
import json, sys
run = json.load(open(sys.argv[1]))
tests = [t for s in run["testsuites"] for t in s["testsuite"]]
failed = sum("failures" in t for t in tests)
skipped = sum(t.get("result") == "SKIPPED" for t in tests)
print(f"{len(tests) - failed - skipped} passed, {failed} failed, {skipped} skipped")
PY
exit $status
