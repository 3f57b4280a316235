// Plots are made when their page is first shown, as wide as their place, and again when the width changes.

const COLOURS = ["var(--c0)", "var(--c1)", "var(--c2)", "var(--c3)", "var(--c4)", "var(--c5)"];
// One more than there are colours: the seventh line has the colour of the first one, not its dashes.
const DASHES = ["", "7 3", "2 3", "9 3 2 3", "4 2", "1 2", "12 3 2 3 2 3"];

const colourOf = (n) => COLOURS[n % COLOURS.length];
const dashOf = (n) => DASHES[n % DASHES.length];

/** Draws `make(width)` into a place now and whenever its width changes. Nothing is drawn if it returns null. */
function drawn(place, make) {
  let width = 0;
  const box = h("div", { class: "plot" });
  place.append(box);
  const draw = () => {
    const now = Math.floor(box.clientWidth);
    if (!now || now === width) return;
    width = now;
    box.replaceChildren(make(width));
  };
  new ResizeObserver(draw).observe(box);
  draw();
}

/**
 * A plot that a screen reader takes for one picture with a name. What is drawn in it is hidden from it, but for links,
 * which get the names of their marks; a keyboard finds them in the table below the plot, where they are fewer steps away.
 */
function plotted(options) {
  const svg = Plot.plot(options);
  if (!options.ariaLabel) svg.setAttribute("aria-hidden", "true"); // an axis of other plots
  else svg.setAttribute("role", svg.querySelector("a") ? "group" : "img");
  for (const part of svg.querySelectorAll("g[aria-label]")) {
    if (part.querySelector("a")) part.setAttribute("role", "group");
    else part.setAttribute("aria-hidden", "true");
  }
  for (const link of svg.querySelectorAll("a")) {
    const named = link.querySelector("[aria-label]"), title = link.querySelector("title");
    link.setAttribute("aria-label", named ? named.getAttribute("aria-label") : title ? title.textContent : options.ariaLabel);
    if (named) named.removeAttribute("aria-label");
    link.setAttribute("tabindex", "-1");
  }
  return svg;
}

// Rows of the table of a plot: a curve has its shape in fewer.
const MOST_TABLED = 60;

/** The figures of a plot as a table, made when it is opened; `rows()` are lists of cells. */
function tabled(caption, heads, rows) {
  const box = h("div", { class: "scroll" });
  const details = h("details", { class: "small tabled", ontoggle: () => {
    if (!details.open || box.firstChild) return;
    const all = rows(), step = Math.ceil(all.length / MOST_TABLED), shown = all.filter((_, n) => n % step === 0 || n === all.length - 1);
    box.append(tableOf({ "aria-label": caption }, heads, shown.map((cells) => h("tr", {}, cells.map((cell) => h("td", {}, cell))))));
    if (shown.length < all.length) box.append(h("p", { class: "soft" }, "Each " + step + "th of " + all.length + " rows."));
  } }, h("summary", {}, "As a table"), box);
  return details;
}

/** Options that all plots share. */
function plain(width, options) {
  return Object.assign({
    width, height: 270, marginTop: 28, marginLeft: 56, marginBottom: 42, style: { background: "none", fontSize: "12px" },
  }, options);
}

/** A legend of [name, colour, dash, note] items, drawn as the lines are. */
function legend(items) {
  return h("ul", { class: "legend" }, items.map(([name, colour, dash, note]) => {
    const line = svgElement("path", { d: "M0 5H30", stroke: colour, "stroke-width": 2.5, "stroke-dasharray": dash });
    const sample = svgElement("svg", { viewBox: "0 0 30 10", "aria-hidden": "true" }, [line]);
    return h("li", {}, sample, name, note && h("span", { class: "soft" }, " (" + note + ")"));
  }));
}

/** A figure at a tick of an axis of counts: none between two of them. */
const wholeTick = (value) => (Number.isInteger(value) ? value.toLocaleString("en-US") : "");

/** Options of an axis from one value to the same: it is written once, and not as 1.000000. */
function onlyTick(values, zero) {
  const [least, most] = [Math.min(...values), Math.max(...values)];
  return least === most && !(zero && least) ? { ticks: [least], tickFormat: String } : {};
}

/** Line plot of `series` [{name, points, n, note, curve}] with axes and a legend below; hidden where no line has a point. */
function linePlot(place, series, x, y, label) {
  const kept = series.filter((each) => each.points.length);
  place.hidden = !kept.length;
  if (!kept.length) return;
  const along = (n) => kept.flatMap((each) => each.points.map((point) => point[n]));
  drawn(place, (width) => plotted(plain(width, {
    ariaLabel: label, x: { ...onlyTick(along(0)), ...x }, y: { grid: true, ...(y.domain ? {} : onlyTick(along(1), y.zero)), ...y },
    marks: kept.flatMap((each) => [
      Plot.line(each.points, { x: "0", y: "1", stroke: colourOf(each.n), strokeDasharray: dashOf(each.n), strokeWidth: 2, curve: each.curve || "linear" }),
      each.points.length > 12 || each.curve ? null :
        Plot.dot(each.points, { x: "0", y: "1", r: 3, fill: "var(--card)", stroke: colourOf(each.n), strokeWidth: 2 }),
      Plot.tip(each.points, Plot.pointer({ x: "0", y: "1", title: (point) => visible(each.name) + "\n" + x.label + ": " + point[0] + "\n" + y.label + ": " + point[1], fill: "var(--card)" })),
    ]),
  })));
  place.append(legend(kept.map((each) => [each.name, colourOf(each.n), dashOf(each.n), each.note])));
  place.append(tabled(label, ["Line", x.label, y.label], () => kept.flatMap((each) => each.points.map(([at, value]) => [each.name, at, value]))));
}

/** Per cent from the multiple of ten below the lowest value: suites differ in the upper part. */
function percentDomain(series) {
  const least = Math.min(...series.flatMap((each) => each.points.map((point) => point[1])));
  const low = Math.floor((least - 2) / 10) * 10;
  return [low >= 20 ? low : 0, 100];
}
