// The trend over sessions: the number of a session is on the x axis, the last one is this report's.

function trendPage() {
  const entries = DATA.history, step = Math.ceil(entries.length / 20);
  const ticks = entries.map((_, place) => place + 1).filter((number) => number % step === 0), x = { label: "Session", ticks, tickFormat: String };
  const series = (names) => names.map(([name, read], n) => ({
    name, n, points: entries.map((each, place) => [place + 1, read(each)]).filter((point) => point[1] !== null && point[1] !== undefined),
  }));
  const plot = (id, label, names, domain) => {
    const found = series(names);
    linePlot(document.getElementById(id), found, x, { label, ...(domain ? { domain: percentDomain(found) } : { zero: true, tickFormat: (value) => (label === "s" || Number.isInteger(value) ? String(value) : "") }) }, label + " over sessions");
  };
  const sum = (each, kind) => Object.values(each.requirements || {}).reduce((all, found) => all + found[kind], 0);
  plot("trend-coverage", "%", [["statements", (e) => e.statements], ["branches", (e) => e.branches], ["plans", (e) => e.plans], ["cross products", (e) => e.cross]], true);
  plot("trend-verdicts", "count", [["tests that failed", (e) => (e.failing || []).length], ["verdicts Failed", (e) => sum(e, "failed")], ["verdicts NC", (e) => sum(e, "nc")]]);
  plot("trend-triggers", "triggers", [["of all requirements", (e) => sum(e, "triggers")]]);
  plot("trend-time", "s", [["run time", (e) => e.wall_s || 0]]);
}

PAGES.trend = trendPage;
