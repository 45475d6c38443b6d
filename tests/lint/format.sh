#!/bin/bash
# usage: format.sh: formatting, shell and YAML: no findings, no baseline. Needs no build and takes seconds.
set -euo pipefail
mapfile -t c_files < <(git ls-files -co --exclude-standard core proto server docker tests | grep -E '\.([ch]|cc)$')
mapfile -t scripts < <(git ls-files -co --exclude-standard | xargs grep -lE '^#!(/bin/sh|/bin/bash|/usr/bin/env bash)' --)
printf '%s\n' "${c_files[@]}" | xargs -P "$(nproc)" -n 64 clang-format --dry-run --Werror
shellcheck -x "${scripts[@]}"
yamllint -d '{extends: default, rules: {line-length: {max: 160}, document-start: disable}}' openapi.yaml docker
echo "formatting of ${#c_files[@]} C files, ${#scripts[@]} shell scripts, YAML: ok"
