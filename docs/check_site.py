"""Check a built site: every link leads to a page and an anchor in it, and nothing is remote.

python docs/check_site.py docs/_build/html

Links to other sites are not followed. Exit code 1 with a line for each fault.
"""

from __future__ import annotations

import re
import sys
from collections.abc import Iterator
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit

LOADING = {"script": "src", "img": "src", "source": "src", "iframe": "src", "link": "href"}
"""Tags that make a browser load something by itself, and the attribute that says what."""
STYLE_URL = re.compile(r"@import\s+['\"]|url\(\s*['\"]?(?P<url>[^'\")]+)")


class Page(HTMLParser):
    """Anchors, links and loaded files of one page."""

    def __init__(self) -> None:
        super().__init__()
        self.anchors: set[str] = set()
        self.links: list[str] = []
        self.loaded: list[str] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        """Collect what one tag has."""
        found = {name: value for name, value in attrs if value}
        self.anchors.update(found[name] for name in ("id", "name") if name in found)
        if tag == "a" and "href" in found:
            self.links.append(found["href"])
        if tag in LOADING and LOADING[tag] in found:
            self.loaded.append(found[LOADING[tag]])


def faults(site: Path) -> Iterator[str]:
    """A line for each broken link, missing anchor, missing or remote file of a site."""
    pages = {path: _parsed(path) for path in sorted(site.rglob("*.html"))}
    for path, page in pages.items():
        place = path.relative_to(site)
        for target in page.loaded:
            if _remote(target):
                yield f"{place}: loads {target} from another site"
        for target in [*page.links, *page.loaded]:
            yield from (f"{place}: {fault}" for fault in _fault(path, target, pages))
    for path in site.rglob("*.css"):
        found = (match["url"] or "@import" for match in STYLE_URL.finditer(path.read_text("utf-8")))
        yield from (f"{path.relative_to(site)}: loads {url}" for url in found if _remote(url))


def _parsed(path: Path) -> Page:
    page = Page()
    page.feed(path.read_text(encoding="utf-8"))
    return page


def _remote(target: str) -> bool:
    return target == "@import" or target.startswith(("http:", "https:", "//"))


def _fault(path: Path, target: str, pages: dict[Path, Page]) -> Iterator[str]:
    parts = urlsplit(target)
    if parts.scheme or parts.netloc:
        return
    file = (path.parent / unquote(parts.path)).resolve() if parts.path else path
    if not file.exists():
        yield f"no file {target}"
    elif parts.fragment and file in pages and unquote(parts.fragment) not in pages[file].anchors:
        yield f"no anchor {target}"


if __name__ == "__main__":
    found = list(faults(Path(sys.argv[1]).resolve()))
    sys.stderr.writelines(f"{line}\n" for line in found)
    sys.exit(1 if found else 0)
