"""Flaws of the page as it is shown: what is cut, covered, faint, too wide or without a name."""

from __future__ import annotations

from pathlib import Path
from typing import Any

_CONTRAST = 4.5
"""The least contrast of text (WCAG 2.2, 1.4.3)."""

_LETTERS = 7.0
"""The least size of letters as they are shown [px]: types of ports, just before they are hidden."""


def flaws(page: Any, part: str = "body") -> list[str]:
    """Return the lasting flaws of a part of a page; texts may be cut where a title has all of them.

    Those of a page that is being arranged do not count.
    """
    found: list[str] = []
    for _ in range(_LOOKS):
        page.locator(".wiring[aria-busy=true]").wait_for(state="detached")
        found = page.evaluate(_FLAWS, [_CONTRAST, _LETTERS, part])
        if not found:
            break
        page.wait_for_timeout(_BETWEEN)
    return found


def violations(page: Any) -> list[str]:
    """Return what axe-core finds against a page."""
    if not page.evaluate("typeof axe === 'object'"):
        page.evaluate(AXE.read_text(encoding="utf-8"))
    found: list[str] = page.evaluate(
        """axe.run().then(({ violations }) => violations.flatMap(each =>
            each.nodes.map(node => `${each.id}: ${node.html.slice(0, 120)}`)))"""
    )
    return found


def too_small(page: Any) -> list[str]:
    """Return what can be touched, but is smaller than a finger (WCAG 2.2, 2.5.5).

    Links in a text do not count, nor what is zoomed.
    """
    found: list[str] = page.evaluate(_SMALL, _TOUCH)
    return found


_TOUCH = 44
"""The least width and height of what is touched [px]."""

_SMALL = """least => [...document.querySelectorAll(
    "button, select, input, textarea, [role=tab], summary, a, [cmdk-item]")]
    .filter(each => each.checkVisibility({ visibilityProperty: true })
        && !each.closest(".link, .react-flow__viewport, .react-flow__attribution"))
    .map(each => [each, (each.matches("[type=checkbox], [type=radio]") && each.closest("label")
        || each).getBoundingClientRect()])
    .filter(([each, { width, height }]) => height < least - 0.5 && height > 0
        || (width < least - 0.5 && width > 0 && !each.matches("summary, [type=checkbox]")))
    .map(([each, { width, height }]) => `${each.tagName} ${each.getAttribute("aria-label")
        ?? each.textContent.slice(0, 30)} ${width}x${height}`)"""


AXE = Path(__file__).parents[3] / "ui/node_modules/axe-core/axe.min.js"
_LOOKS = 30
_BETWEEN = 100
"""Milliseconds between two looks."""

_FLAWS = """async ([contrast, least, part]) => {
    const flaws = [];
    // What a map has written last: inside of it, and no two texts over each other.
    for (const map of document.querySelectorAll(`${part} .map canvas`)) {
        if (!map.clientWidth) continue;
        const context = map.getContext("2d");
        const { clearRect, fillText } = CanvasRenderingContext2D.prototype;
        let texts = [];
        context.clearRect = (...area) => {
            texts = [];
            clearRect.apply(context, area);
        };
        context.fillText = (text, x, y) => {
            const { width, actualBoundingBoxAscent: above } = context.measureText(text);
            texts.push({ text, left: x, right: x + width, top: y - above, bottom: y });
            fillText.call(context, text, x, y);
        };
        const frame = () => new Promise(requestAnimationFrame);
        await frame().then(frame);
        delete context.clearRect;
        delete context.fillText;
        for (const [i, one] of texts.entries()) {
            if (one.left < 0 || one.top < 0
                || one.right > map.clientWidth || one.bottom > map.clientHeight)
                flaws.push(`cut on the map: ${one.text}`);
            for (const other of texts.slice(i + 1))
                if (one.left < other.right && other.left < one.right
                    && one.top < other.bottom && other.top < one.bottom)
                    flaws.push(`over each other on the map: ${one.text}, ${other.text}`);
        }
    }
    const about = each => {
        const name = each.getAttribute("aria-label") ?? each.textContent.trim().slice(0, 40);
        return `${each.tagName.toLowerCase()}.${each.className} "${name}"`;
    };
    const seen = each => {
        const { width, height } = each.getBoundingClientRect();
        return width > 2 && height > 2 && each.checkVisibility({ visibilityProperty: true });
    };
    const light = ([r, g, b]) => {
        const [x, y, z] = [r, g, b].map(
            v => v / 255 <= 0.04045 ? v / 255 / 12.92 : ((v / 255 + 0.055) / 1.055) ** 2.4);
        return 0.2126 * x + 0.7152 * y + 0.0722 * z;
    };
    const pen = new OffscreenCanvas(1, 1).getContext("2d", { willReadFrequently: true });
    const colour = text => {
        pen.clearRect(0, 0, 1, 1);
        pen.fillStyle = text;
        pen.fillRect(0, 0, 1, 1);
        return [...pen.getImageData(0, 0, 1, 1).data];
    };
    const paper = each => {
        for (let at = each; at; at = at.parentElement) {
            const found = colour(getComputedStyle(at).backgroundColor);
            if (found[3] === 255) return found;
        }
        return colour("Canvas");
    };
    const cut = (each, text) => {
        const bare = text => text.replace(/\\s+/g, "");
        const title = each.closest("[title]")?.title ?? "";
        if (!bare(title).includes(bare(text))) flaws.push(`cut: ${about(each)}: ${text}`);
    };
    const outside = (each, x, y) => {
        for (let at = each.parentElement; at; at = at.parentElement) {
            const { left, right, top, bottom } = at.getBoundingClientRect();
            if (getComputedStyle(at).overflowY !== "visible"
                && (x < left || x > right || y < top || y > bottom)) return true;
        }
        return false;
    };
    // Names of boxes are covered by nothing that stands on the wiring.
    const names = `${part} :is(.box .head strong, .bus-node strong)`;
    for (const each of document.querySelectorAll(names)) {
        const { left, top, width, height } = each.getBoundingClientRect();
        const over = document.elementFromPoint(left + width / 2, top + height / 2);
        if (seen(each) && over?.closest(".react-flow__panel, .react-flow__minimap, .peek"))
            flaws.push(`covered: ${about(each)} by ${about(over)}`);
    }
    // They are whole, one word in one line, as long as their letters could be smaller.
    for (const each of document.querySelectorAll(`${part} .far :is(.head, .bus-node) strong`)) {
        const size = parseFloat(getComputedStyle(each).fontSize);
        const drawn = size * each.getBoundingClientRect().width / each.offsetWidth;
        if (!seen(each) || drawn < least + 0.1) continue;
        const words = document.createTreeWalker(each, NodeFilter.SHOW_TEXT);
        let broken = each.scrollWidth > each.clientWidth + 1;
        while (words.nextNode()) {
            const range = document.createRange();
            range.selectNodeContents(words.currentNode);
            const lines = new Set([...range.getClientRects()].map(({ top }) => Math.round(top)));
            broken ||= lines.size > 1 && !/\\s/.test(words.currentNode.data);
        }
        if (broken) flaws.push(`broken: ${about(each)}`);
    }
    // What wires lose hides no name.
    const marks = [...document.querySelectorAll(`${part} .far .health`)]
        .map(each => each.getBoundingClientRect());
    for (const each of document.querySelectorAll(`${part} .far .head strong`)) {
        const range = document.createRange();
        range.selectNodeContents(each);
        const covered = one => marks.some(other => one.left < other.right - 1
            && other.left < one.right - 1 && one.top < other.bottom - 1
            && other.top < one.bottom - 1);
        if (seen(each) && [...range.getClientRects()].some(covered))
            flaws.push(`covered by a mark: ${about(each)}`);
    }
    // Lines to a bus go through no box.
    const boxes = [...document.querySelectorAll(`${part} .box`)].filter(seen);
    const inside = boxes.map(each => [each, each.getBoundingClientRect()]);
    for (const each of document.querySelectorAll(`${part} .drop`)) {
        const [whole, onto] = [each.getTotalLength(), each.getScreenCTM()];
        for (let at = 4; at < whole - 4; at += 4) {
            const { x, y } = each.getPointAtLength(at).matrixTransform(onto);
            const found = inside.find(([, { left, right, top, bottom }]) =>
                x > left + 2 && x < right - 2 && y > top + 2 && y < bottom - 2);
            if (!found) continue;
            flaws.push(`a line to a bus through ${about(found[0])}`);
            break;
        }
    }
    const page = document.documentElement;
    if (page.scrollWidth > innerWidth) flaws.push(`the page is ${page.scrollWidth} px wide`);
    for (const each of document.querySelectorAll(".palette, .panel, header, .notice"))
        if (each.scrollWidth > each.clientWidth + 1) {
            const end = each.getBoundingClientRect().left + each.clientWidth + 1;
            const wide = [...each.querySelectorAll("*")].findLast(
                inner => inner.getBoundingClientRect().right > end);
            flaws.push(`too wide: ${about(wide ?? each)} in ${each.className}`);
        }
    for (const each of document.querySelectorAll(`${part} *`)) {
        if (!seen(each) || each.closest(".react-flow__attribution, .announced, svg")) continue;
        const style = getComputedStyle(each);
        const own = [...each.childNodes].some(n => n.nodeType === 3 && n.data.trim());
        const field = each.matches(
            "input:not([type=range], [type=checkbox], [type=radio]), textarea");
        if (each.matches("select") && style.appearance !== "base-select") {
            pen.font = style.font;
            const text = each.selectedOptions[0]?.textContent ?? "";
            if (pen.measureText(text).width > each.clientWidth - 20)
                cut(each, text);
        } else if ((field || own) && style.display !== "inline"
            && (field || !["visible", "auto", "scroll"].includes(style.overflowX))
            && (each.scrollWidth > each.clientWidth + 1
                || each.scrollHeight > each.clientHeight + 3))
            cut(each, each.value ?? each.textContent);
        let block = each;
        while (getComputedStyle(block).display === "inline") block = block.parentElement;
        const { width: across } = block.getBoundingClientRect();
        const drawn = parseFloat(style.fontSize) * across / (block.offsetWidth || across);
        if (own && drawn < least) flaws.push(`small ${drawn.toFixed(1)} px: ${about(each)}`);
        const off = each.closest(":disabled, [aria-disabled=true]");
        if (own && !off) {
            const [one, other] = [light(colour(style.color)), light(paper(each))];
            const found = (Math.max(one, other) + 0.05) / (Math.min(one, other) + 0.05);
            if (found < contrast) flaws.push(`contrast ${found.toFixed(1)}: ${about(each)}`);
        }
        if (each.matches("button, select, input, textarea, [role=img], [role=application]")) {
            const label = each.getAttribute("aria-label") || each.labels?.[0]?.textContent
                || each.textContent || each.title;
            if (!label?.trim()) flaws.push(`no name: ${each.outerHTML.slice(0, 80)}`);
            const { left, top, width, height } = each.getBoundingClientRect();
            const [x, y] = [left + width / 2, top + height / 2];
            const hit = document.elementFromPoint(x, y);
            if (hit && !outside(each, x, y) && each.matches("button, select, input, textarea")
                && !each.contains(hit) && !hit.contains(each)
                && !each.labels?.[0]?.contains(hit))
                flaws.push(`covered: ${about(each)} by ${about(hit)}`);
        }
    }
    const texts = document.createTreeWalker(document.querySelector(part), NodeFilter.SHOW_TEXT);
    while (texts.nextNode()) {
        const { parentElement } = texts.currentNode;
        const inParts = parentElement.querySelector(":scope > wbr");
        const data = inParts ? parentElement.textContent : texts.currentNode.data;
        let at = parentElement;
        if (!/[\u202a-\u202e\u2066-\u2069]/.test(data) || !seen(at)) continue;
        const style = () => getComputedStyle(at);
        while (style().display === "inline" && style().unicodeBidi !== "isolate")
            at = at.parentElement;
        if (at.textContent.trim() !== data.trim())
            flaws.push(`turned: ${about(at)} by "${data}"`);
    }
    return flaws;
}"""
