#!/usr/bin/env python3
"""Runs clang-tidy, as .clang-tidy says, over every source file: tools/tidy.py [FILE...]

Needs the preset "clang" configured (cmake --preset clang): its commands are followed. What has passed is remembered in
build-clang/tidy by what the compiler sees of it, so a second run looks only at what has changed. Exit code 1 where
anything is said.
"""
import concurrent.futures
import hashlib
import json
import os
import pathlib
import shlex
import subprocess
import sys

TREE = pathlib.Path(__file__).resolve().parent.parent
BUILD = TREE / "build-clang"
SEEN = BUILD / "tidy"


def key_of(entry, rules):
    """What decides the answer: the rules, and the file with all that it includes."""
    words = shlex.split(entry["command"])
    words = words[1:] if words[0].endswith("ccache") else words
    at = words.index("-o")
    command = words[:at] + words[at + 2:] + ["-E", "-C", "-o", "-"]
    text = subprocess.run(command, cwd=entry["directory"], capture_output=True, check=False).stdout
    return hashlib.sha256(rules + text).hexdigest()


def check(entry, rules):
    """The file's name and what is said about it; None where nothing is."""
    name = os.path.relpath(entry["file"], TREE)
    stamp = SEEN / key_of(entry, rules)
    if stamp.exists():
        return name, None
    run = subprocess.run(["clang-tidy", "--quiet", "-p", str(BUILD), entry["file"]], capture_output=True, text=True, check=False)
    if run.returncode == 0:
        stamp.touch()
        return name, None
    return name, run.stdout.strip() or run.stderr.strip()


def main():
    wanted = {str(pathlib.Path(f).resolve()) for f in sys.argv[1:]}
    commands = BUILD / "compile_commands.json"
    if not commands.exists():
        sys.exit("tidy.py: run cmake --preset clang first")
    entries = {e["file"]: e for e in json.loads(commands.read_text())}  # once where several targets have a file
    entries = [e for f, e in sorted(entries.items()) if not wanted or f in wanted]
    SEEN.mkdir(exist_ok=True)
    rules = (TREE / ".clang-tidy").read_bytes()
    bad = 0
    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        for done, (name, said) in enumerate(pool.map(lambda e: check(e, rules), entries), 1):
            if said:
                bad += 1
                print(f"[{done}/{len(entries)}] {name}\n{said}", flush=True)
    print(f"{len(entries)} files, {bad} with remarks")
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main())
