"""`w2c replay FILE --through SERVICE`: does a service answer as it did?"""

import json
from pathlib import Path

from w2c.extras import needs_extra
from w2c.through import through
from w2c_recorder.reading import Recording
from w2c_recorder.report import Report, spare, write_file
from w2c_recorder.series import files_of
from w2c_recorder.through.options import ThroughOptions
from w2c_recorder.through.session import RecordedSession
from w2c_recorder.through.tally import Tally


def run(path: Path, options: ThroughOptions) -> int:
    """Run a service on its recorded inputs, and print how its outputs compare.

    Returns the exit status: 0 = every output that was compared is equal, or within the tolerance;
    1 = one is not, or none could be compared.

    Raises:
        RecordingError: there is no such recording, or what the service must know is not in it.
        ConfigError: this service cannot be run on a recording.
    """
    if path.exists():
        spare(files_of(path).values(), options.json)
    report = compare(path, options)
    for line in report.lines:
        print(line)
    if options.json is not None:
        write_file(options.json, (json.dumps(report.values, indent=1) + "\n").encode())
    return report.status


def compare(path: Path, options: ThroughOptions) -> Report:
    """Return how the outputs of a service compare. Raises as `run` does."""
    recording = Recording(path)
    recording.read_metadata()
    with needs_extra(options.service):
        make_again = through(options.service)
        tally = Tally(options.tolerance, options.start_s, options.end_s)
        session = RecordedSession(recording, options.end_s)
        for result in make_again(session, options.tolerance):
            tally.add(result)
    report = tally.report(f"{path}, through {options.service} of this version")
    if recording.read_whole:
        report.lines.extend(recording.damage.lines())
    return report
