"""The codec under hostile payloads, in short; `make fuzz` takes a million."""

import random

from lab.measure.fuzz import MOST_GROWTH_MB, MUTATIONS, fuzz, most_memory_mb, seeds, targets, verdict

KNOWN_REASONS = {"valid", "malformed", "oversized", "version", "invalid", "not_finite"}


def test_every_message_of_the_wire_has_a_seed() -> None:
    assert {target for _, target in seeds()} == set(targets())


def test_hostile_payloads_are_refused_for_known_reasons_and_leave_no_memory_behind() -> None:
    fuzz(2_000, seed=0)
    before_mb = most_memory_mb()
    verdicts = fuzz(15_000, seed=7)
    assert set(verdicts) == KNOWN_REASONS
    assert verdicts["valid"] < 0.2 * verdicts.total()
    assert most_memory_mb() - before_mb < MOST_GROWTH_MB


def test_every_mutation_is_refused_sometimes() -> None:
    rng, known = random.Random(3), seeds()  # noqa: S311  # as in the benchmark
    for mutation in MUTATIONS:
        told = {verdict(mutation(rng, payload), target) for payload, target in known for _ in range(5)}
        assert told - {"valid"}, mutation.__name__
