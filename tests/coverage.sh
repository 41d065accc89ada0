#!/usr/bin/env bash
# Which lines the default tests run, kernels included: bash tests/coverage.sh [words for pytest]
# (once before: pip install -e '.[test,dev]'). What is compiled hides from the count, so the tests of the kernels run
# first with numba switched off, then all tests as they are. A share below 95 % is an error.
set -euo pipefail
cd "$(dirname "$0")/.."
export COVERAGE_FILE=${COVERAGE_FILE:-.coverage} # names each line's tests too: tests/mutate.py
count=(-q -p no:cacheprovider --cov=roughsim --cov=theory --cov-context=test)
kernels="kernels or half_space or ((contact_operator or contact_solver) and (dense_transform or half_spectrum or push_pull or moves_no_point
  or near_its_bound or worst_point or mean_square or interpolation))"
rm -f "$COVERAGE_FILE"
NUMBA_DISABLE_JIT=1 python -m pytest "${count[@]}" --cov-report= \
  tests/kernels/test_kernels.py tests/heat/test_half_space.py tests/contact/test_contact_operator.py tests/contact/test_contact_solver.py -k "${kernels//$'\n'/ }"
python -m pytest "${count[@]}" --cov-append --cov-report=term:skip-covered --cov-fail-under=95 "$@"
