#!/bin/sh
# check.sh MODELS JOBS REPORT: norma check over a folder, in JOBS parts, by GNU parallel. Its exit status is that of one
# run over all files. --sshlogin in $PARALLEL spreads the jobs over machines that share the folder.
set -eu
models=$1 jobs=$2 report=$3
parts=$(mktemp -d)
trap 'rm -rf "$parts"' EXIT
# --exit job: what is found ends no job; a job that fails is run again, twice. -q: spaces and $ in names stay what they are.
seq "$jobs" | parallel -q --retries 3 norma check "$models" --shard "{}/$jobs" --threads 1 --exit job --quiet --format json -o "$parts/{}.json"
norma report --merge "$parts"/*.json -o "$report"
