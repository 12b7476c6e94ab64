"""Learning, from the command line: ``python -m model.training COMMAND``."""

import argparse
import sys
from pathlib import Path

from model.checksums import write_sums
from model.template_mesh import DATA
from model.training.law_fit import write_survey_laws
from model.training.spreads import write_survey_measurements
from model.training.survey import SEXES, write_statistics


def main() -> None:
    """Runs one command of the command line."""
    parser = argparse.ArgumentParser(prog="python -m model.training", description=__doc__)
    commands = parser.add_subparsers(dest="command", required=True)
    survey = commands.add_parser("survey", help="write the survey's statistics from its rows")
    survey.add_argument("folder", type=Path, help="holds female_half_a.csv and male_half_a.csv")
    commands.add_parser("population", help="build the open population through Anny")
    stance = commands.add_parser("stance", help="write docs/stance.md, on people drawn anew")
    stance.add_argument("--seed", type=int, default=1, help="%(default)s is the default")
    commands.add_parser("rig", help="carry over Anny's skeleton and skinning weights")
    commands.add_parser("sums", help="write the checksums of the shipped estimators' files anew")
    commands.add_parser("train", help="train the shipped estimators from the shipped population")
    commands.add_parser("measurements", help="write docs/measurements.md with its pictures")
    commands.add_parser("guide", help="draw the pictures of the wizard's guide, in static/guide/")
    report = commands.add_parser("report", help="write population, paper and validation in docs/")
    report.add_argument(
        "--survey-rows", type=Path, help="the survey's rows, for errors on real people"
    )
    _add_scans(commands.add_parser("scans", help="train on registered scans: docs/scans.md"))
    arguments = parser.parse_args()
    # Each command imports what it needs: few of them need PyTorch.
    if arguments.command == "survey":
        for sex in SEXES:
            people = write_statistics(sex, arguments.folder / f"{sex}_half_a.csv").people
            print(f"{sex}: statistics of {people} people")
        print(f"measurements: {write_survey_measurements(arguments.folder)} rows")
        print(f"laws of {write_survey_laws(arguments.folder)} people")
    elif arguments.command == "population":
        from model.training.population_build import build

        build()
    elif arguments.command == "stance":
        from model.training.fresh_people import write_stance_report

        write_stance_report(arguments.seed)
    elif arguments.command == "rig":
        from model.training.anny_rig import write_rig

        print(f"wrote {write_rig()}")
        write_sums(DATA)
    elif arguments.command == "sums":
        print(f"wrote {write_sums(DATA)}")
    elif arguments.command == "measurements":
        from model.training.measurement_guide import write_guide

        write_guide()
    elif arguments.command == "guide":
        from model.training.guide_pictures import draw_guide

        draw_guide()
    elif arguments.command == "train":
        from model.training.train import train

        train()
    elif arguments.command == "scans":
        _train_on_scans(arguments)
    else:
        from model.training.report import write_report

        write_report(arguments.survey_rows)


def _add_scans(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "folder",
        type=Path,
        nargs="?",
        help="holds a folder of each sex, told by its name, such as SPRING_FEMALE and SPRING_MALE",
    )
    for sex in SEXES:
        parser.add_argument(f"--{sex}", type=Path, metavar="FOLDER", help=f"the {sex} scans")
    parser.add_argument(
        "--output", type=Path, default=Path("build/scans"), help="%(default)s is the default"
    )
    parser.add_argument("--unit", choices=("m", "cm", "mm"), help="recognised by default")
    axes = [f"{sign}{axis}" for axis in "xyz" for sign in "+-"]
    for name, what in (("up", "people stand"), ("front", "people look")):
        parser.add_argument(
            f"--{name}",
            choices=axes,
            metavar="AXIS",
            help=f"where {what}, such as --{name}=-y; recognised by default",
        )
    parser.add_argument("--jobs", type=int, default=-1, help="processes; one a core by default")
    parser.add_argument("--dask", metavar="ADDRESS", help="work on the cluster of this scheduler")


def _train_on_scans(arguments: argparse.Namespace) -> None:
    from model.training.scans import Known, train_on_scans
    from model.training.scans_files import ScanError

    try:
        train_on_scans(
            arguments.folder,
            {"female": arguments.female, "male": arguments.male},
            output=arguments.output,
            known=Known(arguments.unit, arguments.up, arguments.front),
            jobs=arguments.jobs,
            dask=arguments.dask,
        )
    except (ScanError, OSError, ModuleNotFoundError) as error:
        sys.exit(f"scans: {error}")


if __name__ == "__main__":
    main()
