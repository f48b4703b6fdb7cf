"""Write the results of all cases as one HTML page that needs no other file."""

from __future__ import annotations

from collections.abc import Mapping
from html import escape

from neve.validate.registry import CASES, Case
from neve.validate.report.plots import svg
from neve.validate.result import Check, Result

STYLE = """
:root { color-scheme: light; --ink: #1d2733; --soft: #5d6b7a; --line: #dde4eb; --good: #1f7a4d;
  --bad: #b3261e; }
body { font: 16px/1.55 system-ui, -apple-system, "Segoe UI", Roboto, sans-serif; color: var(--ink);
  background: #f4f7fa; margin: 0; }
main { max-width: 58rem; margin: 0 auto; padding: 2.5rem 1.25rem 4rem; }
h1 { font-size: 2rem; margin: 0 0 .3rem; letter-spacing: -.01em; }
h2 { font-size: 1.3rem; margin: 0; }
h2 small { color: var(--soft); font-weight: 400; font-size: .85rem; margin-left: .5rem; }
p { margin: .6rem 0; }
.lead { color: var(--soft); max-width: 44rem; }
section { background: #fff; border: 1px solid var(--line); border-radius: 12px; padding: 1.4rem 1.5rem;
  margin: 1.6rem 0; }
table { border-collapse: collapse; width: 100%; font-size: .9rem; font-variant-numeric: tabular-nums; }
th { text-align: left; font-weight: 600; color: var(--soft); border-bottom: 1px solid var(--line);
  padding: .35rem .5rem; }
td { border-bottom: 1px solid var(--line); padding: .35rem .5rem; vertical-align: top; }
tr:last-child td { border-bottom: 0; }
td.n, th.n { text-align: right; white-space: nowrap; }
td.why { color: var(--soft); font-size: .84rem; }
.mark { font-weight: 600; white-space: nowrap; }
.mark.good { color: var(--good); } .mark.bad { color: var(--bad); }
.wide { overflow-x: auto; }
.equations { border-left: 3px solid #7d8fa3; padding: .2rem 0 .2rem .9rem; margin: .8rem 0; }
.equations div { font-family: "Cambria Math", Cambria, Georgia, serif; font-size: 1.04rem; }
.source, .remark { color: var(--soft); font-size: .88rem; }
.verdict { font-weight: 500; }
figure { margin: 1rem 0 .4rem; } svg { width: 100%; height: auto; max-width: 46rem; display: block; }
a { color: #1769aa; text-decoration: none; } a:hover { text-decoration: underline; }
"""


def page(results: Mapping[str, Result], version: str) -> str:
    """Return the page. `results` are reported in the order in which they come."""
    good = sum(result.ok for result in results.values())
    count = sum(len(result.checks) for result in results.values())
    body = "".join(_section(CASES[name], result) for name, result in results.items())
    return (
        '<!doctype html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        f"<title>Validation of Neve "
        f"{escape(version)}</title>\n<style>{STYLE}</style>\n</head>\n<body><main>\n"
        f"<h1>Validation of Neve {escape(version)}</h1>\n"
        '<p class="lead">Experiments whose answers are known, run through the public interface. '
        f"{good} of {len(results)} cases hold, with {count} checks. In every plot the black line is the "
        f"exact "
        "answer and the grey band its tolerance; colours are what Neve measured.</p>\n"
        f"{_summary(results)}{body}</main></body>\n</html>\n"
    )


def number(value: float) -> str:
    """Return a number with four digits that count."""
    text = f"{value:.4g}"
    mantissa, _, exponent = text.partition("e")
    return f"{mantissa}&middot;10<sup>{int(exponent)}</sup>" if exponent else text.replace("-", "&minus;")


def expected(check: Check) -> str:
    """Return the exact number of a check, or its bound."""
    sign = {"within": "", "at most": "&le; ", "at least": "&ge; "}[check.rule]
    return sign + number(check.exact)


def allowed(check: Check) -> str:
    """Return the tolerance of a check."""
    return "bound" if check.rule != "within" else f"&plusmn; {number(check.tolerance)}"


def _mark(ok: bool) -> str:
    return f'<span class="mark {"good" if ok else "bad"}">{"&#10003; pass" if ok else "&#10007; fail"}</span>'


def _summary(results: Mapping[str, Result]) -> str:
    rows = []
    for name, result in results.items():
        check = next((check for check in result.checks if not check.ok), result.checks[0])
        held = sum(check.ok for check in result.checks)
        unit = f" {escape(check.unit)}" if check.unit else ""
        rows.append(
            f'<tr><td><a href="#{name}">{escape(CASES[name].title)}</a></td><td>{check.quantity}</td>'
            f'<td class="n">{number(check.measured)}{unit}</td><td class="n">{expected(check)}{unit}</td>'
            f'<td class="n">{allowed(check)}</td><td class="n">{held} of {len(result.checks)}</td>'
            f"<td>{_mark(result.ok)}</td></tr>"
        )
    head = (
        "<tr><th>Case</th><th>First check</th><th class=n>Measured</th><th class=n>Exact</th>"
        "<th class=n>Tolerance</th><th class=n>Checks</th><th></th></tr>"
    )
    return f'<section><div class="wide"><table>{head}{"".join(rows)}</table></div></section>\n'


def _section(case: Case, result: Result) -> str:
    equations = "".join(f"<div>{line}</div>" for line in result.equations)
    plots = "".join(f"<figure>{svg(plot)}</figure>" for plot in result.plots)
    remarks = "".join(f'<p class="remark">{remark}</p>' for remark in result.remarks)
    return (
        f'<section id="{case.name}"><h2>{escape(case.title)}'
        f"<small>{case.name} &middot; known answer {case.number}</small></h2>\n"
        f'<p>{result.what}</p><div class="equations">{equations}</div>'
        f'<p class="source">{result.source}</p>\n{plots}\n{_table(result)}\n'
        f'<p class="verdict">{_mark(result.ok)} &nbsp; {result.verdict}</p>{remarks}</section>\n'
    )


def _table(result: Result) -> str:
    rows = []
    for check in result.checks:
        unit = f" {escape(check.unit)}" if check.unit else ""
        rows.append(
            f'<tr><td>{check.quantity}</td><td class="n">{number(check.measured)}{unit}</td>'
            f'<td class="n">{expected(check)}{unit}</td><td class="n">{allowed(check)}</td>'
            f'<td>{_mark(check.ok)}</td><td class="why">{check.reason}</td></tr>'
        )
    head = (
        "<tr><th>Quantity</th><th class=n>Measured</th><th class=n>Exact</th><th class=n>Tolerance</th>"
        "<th></th><th>Why this tolerance</th></tr>"
    )
    return f'<div class="wide"><table>{head}{"".join(rows)}</table></div>'
