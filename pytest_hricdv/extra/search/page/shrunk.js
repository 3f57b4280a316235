// What a failing test was shrunk to.

function shrunkView(shrunk) {
  if (shrunk.note) return section(shrunk.requirement + " was not shrunk", h("p", {}, shrunk.note));
  return section(shrunk.requirement + " with " + shrunk.abstract.length + " of " + shrunk.from + " actions",
    h("ol", { class: "mono" }, shrunk.abstract.map((line) => h("li", {}, line))),
    shrunk.takes && h("p", {}, shrunk.takes), shrunk.rerun && command(shrunk.rerun));
}

TEST_SECTIONS.last.push((found) => found.shrunk.map(shrunkView));
