"""A command whose options stand in groups in its help."""

from collections.abc import Mapping

import click

SAID = "What is said"
OTHER = "Other"
#: Heading -> the options below it, by the names of their values, in this order.
GROUPS: Mapping[str, tuple[str, ...]] = {
    "Job": (
        "output", "machine", "config_file", "trust", "job", "bar", "bars", "remnants",
        "nest", "order", "turn", "style",
        "show", "to", "table", "quantity", "against", "mark_from", "first", "after",
    ),
    "Names and folders": ("name", "flat", "done", "refused", "samples"),
    "What may be left out": ("skips", "exit_left_out", "strict", "no_verify"),
    "Members of a building model": (
        "marks", "guids", "classes", "assemblies", "force", "letter", "check"
    ),
    "How files are read": ("units", "width", "layers", "fit", "encoding"),
    "How sheets are cut": (
        "colours", "thickness", "material", "amps", "nozzle", "kerf", "kerf_by", "lead",
        "lead_in", "lead_out", "tabs", "tab_width",
        "inner_tabs", "overcut", "gap", "allow_open", "place", "origin", "mirror", "rotate",
        "copies", "spacing", "common_cuts", "skeleton_cuts", "sheet_size", "unrolled",
    ),
    "How the work is done": (
        "jobs", "scheduler", "redo", "dry", "settle", "end_wait", "every", "encoder", "modbus",
        "serve", "pace", "once", "update",
    ),
    SAID: ("as_json", "report", "unit", "paper", "quiet", "verbose", "schema"),
}  # fmt: skip


class Grouped(click.Command):
    """A command that prints its options by `GROUPS`; those of no group come last."""

    def format_options(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write each group of options under its heading."""
        rows: dict[str, list[tuple[str, str]]] = {heading: [] for heading in (*GROUPS, OTHER)}
        for param in self.get_params(ctx):
            record = param.get_help_record(ctx) if isinstance(param, click.Option) else None
            if record is not None:
                heading = SAID if "--help" in param.opts else heading_of(param.name or "")
                rows[heading].append(record)
        for heading, records in rows.items():
            if records:
                with formatter.section(heading):
                    formatter.write_dl(records)


def heading_of(name: str) -> str:
    """The heading of an option, by the name of its value."""
    return next((heading for heading, names in GROUPS.items() if name in names), OTHER)
