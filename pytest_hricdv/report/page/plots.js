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

/** Options that all plots share. */
function plain(width, options) {
  return Object.assign({
    width, height: 270, marginTop: 28, marginLeft: 56, marginBottom: 42, style: { background: "none", fontSize: "12px" },
  }, options);
}

/** A legend of [name, colour, dash, note] items, drawn as the lines are. */
function legend(items) {
  return h("ul", { class: "legend" }, items.map(([name, colour, dash, note]) => {
    const sample = document.createElementNS("http://www.w3.org/2000/svg", "svg");
    sample.setAttribute("viewBox", "0 0 30 10");
    sample.setAttribute("aria-hidden", "true");
    const line = document.createElementNS("http://www.w3.org/2000/svg", "path");
    for (const [key, value] of Object.entries({ d: "M0 5H30", stroke: colour, "stroke-width": 2.5, "stroke-dasharray": dash })) {
      line.setAttribute(key, value);
    }
    sample.append(line);
    return h("li", {}, sample, name, note && h("span", { class: "soft" }, " (" + note + ")"));
  }));
}

/** Line plot of `series` [{name, points, n, note, curve}] with axes and a legend below. */
function linePlot(place, series, x, y, label) {
  const kept = series.filter((each) => each.points.length);
  if (!kept.length) {
    place.append(h("p", { class: "soft" }, "Nothing to plot: the report has no such data."));
    return;
  }
  drawn(place, (width) => Plot.plot(plain(width, {
    ariaLabel: label, x, y: { grid: true, ...y },
    marks: kept.flatMap((each) => [
      Plot.line(each.points, { x: "0", y: "1", stroke: colourOf(each.n), strokeDasharray: dashOf(each.n), strokeWidth: 2, curve: each.curve || "linear" }),
      each.points.length > 12 || each.curve ? null :
        Plot.dot(each.points, { x: "0", y: "1", r: 3, fill: "var(--card)", stroke: colourOf(each.n), strokeWidth: 2 }),
      Plot.tip(each.points, Plot.pointer({ x: "0", y: "1", title: (point) => visible(each.name) + "\n" + x.label + ": " + point[0] + "\n" + y.label + ": " + point[1], fill: "var(--card)" })),
    ]),
  })));
  place.append(legend(kept.map((each) => [each.name, colourOf(each.n), dashOf(each.n), each.note])));
}

/** Per cent from the multiple of ten below the lowest value: suites differ in the upper part. */
function percentDomain(series) {
  const least = Math.min(...series.flatMap((each) => each.points.map((point) => point[1])));
  const low = Math.floor((least - 2) / 10) * 10;
  return [low >= 20 ? low : 0, 100];
}
