"""`beamcam completion`: what makes a shell complete commands, options and names of machines."""

import click
from click.shell_completion import get_completion_class

SHELLS = ("bash", "zsh", "fish", "powershell")
#: PowerShell asks as bash does, by the words of the line and the number of the one to complete; it
#: offers names of files by itself where nothing comes back.
POWERSHELL = """\
Register-ArgumentCompleter -Native -CommandName beamcam -ScriptBlock {
    param($word, $line, $position)
    $before = @($line.CommandElements | Where-Object { $_.Extent.EndOffset -lt $position })
    $env:COMP_WORDS = (@($before | ForEach-Object { $_.ToString() }) + $word) -join ' '
    $env:COMP_CWORD = $before.Count
    $env:_BEAMCAM_COMPLETE = 'bash_complete'
    try {
        beamcam | ForEach-Object {
            $kind, $value = $_ -split ',', 2
            if ($kind -eq 'plain') {
                [System.Management.Automation.CompletionResult]::new(
                    $value, $value, 'ParameterValue', $value)
            }
        }
    } finally {
        Remove-Item Env:COMP_WORDS, Env:COMP_CWORD, Env:_BEAMCAM_COMPLETE
    }
}"""


@click.command("completion")
@click.argument("shell", type=click.Choice(SHELLS))
@click.pass_context
def command(ctx: click.Context, shell: str) -> None:
    """Print the lines that make SHELL complete beamcam's commands and options.

    Put them into the file that the shell reads at its start, or where it looks for completions;
    PowerShell's profile calls the file with a dot: . .\\beamcam.ps1

    \b
    beamcam completion bash > ~/.local/share/bash-completion/completions/beamcam
    beamcam completion zsh > ~/.zfunc/_beamcam
    beamcam completion fish > ~/.config/fish/completions/beamcam.fish
    beamcam completion powershell > beamcam.ps1
    """
    if shell == "powershell":
        click.echo(POWERSHELL)
        return
    made = get_completion_class(shell)
    if made is None:
        raise AssertionError(f"click knows {shell}")
    source = made(ctx.find_root().command, {}, "beamcam", "_BEAMCAM_COMPLETE")
    click.echo(source.source_template % source.source_vars())
