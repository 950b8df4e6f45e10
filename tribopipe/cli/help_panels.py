"""How the help of a group of commands lists them: in panels, each command with its whole first sentence."""

from typing import Any

from typer.core import TyperGroup


class HelpPanels(TyperGroup):
    """A group whose help lists commands under the names of their panels, and cuts no sentence off."""

    def format_commands(self, ctx: Any, formatter: Any) -> None:
        """Write a section for each panel, in the order in which panels come."""
        panels: dict[str, list[tuple[str, str]]] = {}
        for name in self.list_commands(ctx):
            command: Any = self.get_command(ctx, name)
            if not command.hidden:
                panel = getattr(command, "rich_help_panel", None)
                panels.setdefault(panel if isinstance(panel, str) else "Commands", []).append(
                    (name, first_sentence(command.help or ""))
                )
        widest = max((len(name) for rows in panels.values() for name, _ in rows), default=0)
        for panel, rows in panels.items():
            with formatter.section(panel):
                formatter.write_dl([(name.ljust(widest), told) for name, told in rows])


def first_sentence(text: str) -> str:
    """Return the first sentence of a help text, on one line."""
    first = " ".join(text.split("\n\n", 1)[0].split())
    return f"{first.partition('. ')[0].rstrip('.')}."
