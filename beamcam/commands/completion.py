"""`beamcam completion`: what makes a shell complete commands, options and names of machines."""

import click
from click.shell_completion import get_completion_class

SHELLS = ("bash", "zsh", "fish")


@click.command("completion")
@click.argument("shell", type=click.Choice(SHELLS))
@click.pass_context
def command(ctx: click.Context, shell: str) -> None:
    """Print the lines that make SHELL complete beamcam's commands and options.

    Put them into the file that the shell reads at its start, or where it looks for completions.

    \b
    beamcam completion bash > ~/.local/share/bash-completion/completions/beamcam
    beamcam completion zsh > ~/.zfunc/_beamcam
    beamcam completion fish > ~/.config/fish/completions/beamcam.fish
    """
    made = get_completion_class(shell)
    if made is None:
        raise AssertionError(f"click knows {shell}")
    source = made(ctx.find_root().command, {}, "beamcam", "_BEAMCAM_COMPLETE")
    click.echo(source.source_template % source.source_vars())
