"""Results as text and HTML."""

from __future__ import annotations

import itertools

from mrm_mtlx.system.shown import COLUMNS, html_table, in_lines, preformatted


def test_items_fill_lines_and_none_is_broken():
    items = [f"{'x' * n}y" for n in range(5, 40, 3)]
    lines = in_lines(items, indent=11)
    assert " ".join(lines) == ", ".join(items)
    assert max(map(len, lines)) + 11 <= COLUMNS
    assert all(len(line) + 1 + len(after.split()[0]) + 11 > COLUMNS for line, after in itertools.pairwise(lines))


def test_an_item_that_is_longer_than_a_line_has_one_of_its_own():
    assert in_lines(["a", "b" * 100, "c"]) == ["a,", f"{'b' * 100},", "c"]


def test_markup_and_controls_are_shown_as_text():
    assert preformatted("<b>\x1b&\n</pre>").endswith(">&lt;b&gt; &amp;\n&lt;/pre&gt;</pre>")
    page = html_table(["<i>"], [["<td>"]], "<u>")
    assert "<i>" not in page.replace("&lt;i&gt;", "")
    assert page.count("<td") == 1
    assert "&lt;u&gt;" in page
