"""Learning, from the command line: ``python -m model.training COMMAND``."""

import argparse
from pathlib import Path

from model.training.spreads import write_survey_measurements
from model.training.survey import SEXES, write_statistics


def main() -> None:
    """Runs one command of the command line."""
    parser = argparse.ArgumentParser(prog="python -m model.training", description=__doc__)
    commands = parser.add_subparsers(dest="command", required=True)
    survey = commands.add_parser("survey", help="write the survey's statistics from its rows")
    survey.add_argument("folder", type=Path, help="holds female_half_a.csv and male_half_a.csv")
    commands.add_parser("population", help="build the open population through Anny")
    commands.add_parser("train", help="train the shipped estimators from the shipped population")
    commands.add_parser("measurements", help="write docs/measurements.md with its pictures")
    report = commands.add_parser("report", help="write population, paper and validation in docs/")
    report.add_argument(
        "--survey-rows", type=Path, help="the survey's rows, for errors on real people"
    )
    arguments = parser.parse_args()
    # Each command imports what it needs: only one of them needs PyTorch.
    if arguments.command == "survey":
        for sex in SEXES:
            people = write_statistics(sex, arguments.folder / f"{sex}_half_a.csv").people
            print(f"{sex}: statistics of {people} people")
        print(f"measurements: {write_survey_measurements(arguments.folder)} rows")
    elif arguments.command == "population":
        from model.training.population_build import build

        build()
    elif arguments.command == "measurements":
        from model.training.measurement_guide import write_guide

        write_guide()
    elif arguments.command == "train":
        from model.training.train import train

        train()
    else:
        from model.training.report import write_report

        write_report(arguments.survey_rows)


if __name__ == "__main__":
    main()
