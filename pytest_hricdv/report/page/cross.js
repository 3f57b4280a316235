// Cross products as heat maps; with more than two coordinates, two are chosen and the others are summed over.

/** The bin of coordinate `n` in a combination: combinations are numbered, the last coordinate's bins fastest. */
function binAlong(product, combination, n) {
  const step = product.coordinates.slice(n + 1).reduce((all, [, bins]) => all * bins.length, 1);
  return Math.floor(combination / step) % product.coordinates[n][1].length;
}

/** Cells of a heat map: a product along coordinates `x` and `y` (y is null where there is only one). */
function heatCells(product, suite, x, y) {
  const kinds = product.coordinates, cells = new Map();
  const along = (bin, n) => (n === null ? 0 : binAlong(product, bin, n));
  const all = kinds.reduce((count, [, bins]) => count * bins.length, 1);
  const hits = new Map();
  for (const [name, found] of Object.entries(product.suites)) {
    if (suite !== "" && DATA.suites[suite] !== name) continue;
    for (const [bin, tests] of found) hits.set(bin, (hits.get(bin) || 0) + tests);
  }
  for (let bin = 0; bin < all; bin++) {
    const key = along(bin, x) + "/" + along(bin, y);
    if (!cells.has(key)) {
      cells.set(key, { x: kinds[x][1][along(bin, x)], y: y === null ? "" : kinds[y][1][along(bin, y)], href: "#tests/bin/" + [DATA.cross.indexOf(product), x, along(bin, x), ...(y === null ? [] : [y, along(bin, y)])].join("/"), open: 0, illegal: 0, hit: 0, tests: 0, reasons: new Set() });
    }
    const cell = cells.get(key), closed = product.closed.find(([, , bits]) => hasBit(bits, bin)), tests = hits.get(bin) || 0;
    cell.tests += tests;
    if (closed && closed[0] === "illegal" && tests) cell.illegal += 1;
    // A bin that the model makes impossible but a test hits is possible; the totals count it so, too.
    if (closed && (closed[0] === "illegal" || !tests)) {
      cell.reasons.add(closed[0] + ": " + closed[1]);
    } else {
      cell.open += 1;
      cell.hit += tests ? 1 : 0;
    }
  }
  return [...cells.values()];
}

function cellLook(cell, most, single) {
  if (cell.illegal) return { text: "!" + cell.tests, fill: "var(--bad-bg)", stroke: "var(--bad-mark)" };
  if (!cell.open) return { text: "–", fill: "var(--sunk)", stroke: "none" };
  if (!cell.hit) return { text: single ? "0" : "0/" + cell.open, fill: "var(--card)", stroke: "var(--bad-mark)" };
  const share = single ? Math.sqrt(cell.tests / most) : cell.hit / cell.open;
  const fill = "color-mix(in srgb, var(--heat) " + Math.round(12 + 63 * share) + "%, var(--card))";
  return { text: single ? String(cell.tests) : cell.hit + "/" + cell.open, fill, stroke: "none" };
}

function heatPlot(width, product, suite, x, y) {
  const kinds = product.coordinates, single = kinds.length <= 2;
  const cells = heatCells(product, suite, x, y), most = Math.max(1, ...cells.map((cell) => cell.tests));
  for (const cell of cells) cell.look = cellLook(cell, most, single);
  const longest = (n) => (n === null ? 0 : Math.max(...kinds[n][1].map((bin) => bin.length)));
  const marginLeft = Math.min(200, 30 + 7 * longest(y)), columns = kinds[x][1].length;
  const slanted = longest(x) * 7.5 > (width - marginLeft - 20) / columns, marginRight = slanted ? 20 + 4 * longest(x) : 20;
  const tooltip = (cell) => visible([kinds[x][0] + " " + cell.x, y === null ? "" : kinds[y][0] + " " + cell.y,
    cell.hit + " of " + cell.open + " possible hit, in " + cell.tests + " tests", ...cell.reasons].filter(Boolean).join("\n"));
  return plotted(plain(Math.max(width, marginLeft + 44 * columns + marginRight), {
    ariaLabel: "Heat map of " + product.name, marginLeft, marginRight, marginTop: slanted ? 30 + 5 * longest(x) : 40,
    height: 60 + (slanted ? 5 * longest(x) : 0) + 34 * (y === null ? 1 : kinds[y][1].length), marginBottom: 10,
    style: { background: "none", fontSize: "12px", overflow: "visible", maxWidth: "none" }, padding: 0.06,
    x: { label: visible(kinds[x][0]), domain: kinds[x][1], axis: "top", tickRotate: slanted ? -40 : 0, tickFormat: visible },
    y: { label: y === null ? null : visible(kinds[y][0]), domain: y === null ? [""] : kinds[y][1], tickFormat: visible },
    marks: [
      Plot.cell(cells, { x: "x", y: "y", fill: (cell) => cell.look.fill, stroke: (cell) => cell.look.stroke, title: tooltip, href: (cell) => (cell.tests ? cell.href : null) }),
      // A click on the number is a click on the cell below it.
      Plot.text(cells, { x: "x", y: "y", text: (cell) => cell.look.text, fill: "var(--ink)", pointerEvents: "none" }),
      Plot.tip(cells, Plot.pointer({ x: "x", y: "y", title: tooltip, fill: "var(--card)" })),
    ],
  }));
}

/** The heat map's cells as a table. */
function heatTable(product, suite, x, y) {
  const names = [y, x].filter((n) => n !== null).map((n) => product.coordinates[n][0]);
  return tabled("Cells of " + product.name, [...names, "Hit", "Possible", "Tests"], () => heatCells(product, suite, x, y).map((cell) =>
    [...(y === null ? [] : [cell.y]), cell.x, cell.hit, cell.open || [...cell.reasons].join("; "), cell.tests ? h("a", { href: cell.href }, cell.tests) : 0]));
}

function heatMap(product) {
  const names = product.coordinates.map(([name]) => name);
  const place = h("div", { class: "plot scroll" });
  const choose = (label, options, chosen) => {
    const choice = h("select", { "aria-label": label, onchange: () => draw() },
      options.map(([value, text]) => h("option", { value, selected: value === chosen }, text)));
    return choice;
  };
  const suite = choose("Suite", [["", "all suites"], ...DATA.suites.map((name, n) => [String(n), name])], "");
  const axes = names.map((name, n) => [String(n), name]);
  const across = choose("Across", axes, String(Math.min(1, names.length - 1))), down = choose("Down", axes, "0");
  const table = h("div");
  let width = 0;
  const draw = () => {
    if (!width) return;
    const x = Number(across.value), y = across.value === down.value ? null : Number(down.value);
    place.replaceChildren(heatPlot(width, product, suite.value, x, y));
    table.replaceChildren(heatTable(product, suite.value, x, y));
  };
  new ResizeObserver(() => {
    if (place.clientWidth !== width) { width = place.clientWidth; draw(); }
  }).observe(place);
  return h("section", { class: "card" }, h("h3", {}, product.name),
    h("div", { class: "filter" }, DATA.suites.length > 1 && suite,
      names.length > 2 && [h("label", {}, "down ", down), h("label", {}, "across ", across)]),
    place, table,
    h("p", { class: "soft small" },
      names.length > 2 ? "Numbers: combinations hit of those possible, over all other coordinates. " : "Numbers: tests. ",
      "Outlined: not hit. –: impossible or illegal. !: illegal, and hit. ", product.proof),
    holeList(product.holes));
}

/** What no test hit, the largest holes first: closing the first ones brings most. */
function holeList(holes) {
  if (!holes.length) return null;
  const item = (text) => h("li", {}, visible(text)), most = 10;
  return h("div", { class: "holes" }, h("h4", {}, "Not hit by any test, the largest holes first"),
    h("ol", { class: "small" }, holes.slice(0, most).map(item)),
    holes.length > most && h("details", { class: "small" }, h("summary", {}, "and " + (holes.length - most) + " more"),
      h("ol", { start: most + 1 }, holes.slice(most).map(item))));
}

function crossPage() {
  const place = document.getElementById("heatmaps");
  if (!DATA.cross.length) place.append(h("p", { class: "card soft" }, "The testbench declares no cross product."));
  for (const product of DATA.cross) place.append(heatMap(product));
}
