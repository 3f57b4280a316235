"""What the results of a session depend on: suites, options, files and versions. Where all are equal, so are results."""

from __future__ import annotations

from pathlib import Path

from pytest_hricdv._base.project_files import hashes, short_hash, versions
from pytest_hricdv.results.model import SCHEMA
from pytest_hricdv.session.collection import Collection
from pytest_hricdv.session.option import feature_options
from pytest_hricdv.session.options import Options
from pytest_hricdv.session.replaying import Provenance


def fingerprint(collection: Collection, provenance: Provenance) -> dict[str, str]:
    """All that the results of a session depend on: name -> value, or hash.

    Which of the project's files a testbench loads is known only when all tests have run, so all count.
    """
    code = {name: text[:16] for name, text in provenance.code.items()}
    suites = {
        f"suite {generated.suite.name}": short_hash(generated.suite.to_json().encode())
        for generated in collection.selected
    }
    replays = {file.name: short_hash(file.replay.to_json().encode()) for file in collection.replays.values()}
    project = files_and_versions(collection.config.rootpath)
    form = {"report.json": SCHEMA}
    return {**_options(collection.options), **form, **suites, **replays, **project, **code, **provenance.made_with}


def files_and_versions(root: Path) -> dict[str, str]:
    """The sources below a folder, name -> hash, and what is installed, name -> version."""
    return hashes(root) | versions()


def _options(options: Options) -> dict[str, str]:
    """The options that results depend on, as far as suites do not tell."""
    known_violations = (
        f"{name} while {exemption.condition}" if exemption.condition else name
        for name, exemption in options.known_violations.items()
    )
    return {
        "--hri-suite": options.suites,
        "--hri-seed": str(options.seed),
        "--hri-concretizations": str(options.concretizations),
        "--hri-sampling": options.sampling,
        "--hri-fidelity": options.fidelity,
        "--hri-shard": str(options.shard or ""),
        "--hri-no-cov": "" if options.coverage else "set",
        "--hri-strict": "set" if options.strict else "",
        "known violations": ", ".join(sorted(known_violations)),
        **{name: value for feature in feature_options() for name, value in feature.fingerprint(options).items()},
    }
