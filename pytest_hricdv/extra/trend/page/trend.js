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

// Dots of a test's page: as many sessions as fit into a line.
const MOST_DOTS = 30;
// A session names so many failing tests only.
const MOST_NAMED = 200;

/** Whether a test failed in each complete session of the history: a dot each, the last one this report's. */
function historyDots(id) {
  // What has its usual value is left out of a history.
  const known = ({ complete = true, failing = [] }) => complete && (failing.length < MOST_NAMED || failing.includes(id));
  const entries = DATA.history.filter(known).slice(-MOST_DOTS), fails = ({ failing = [] }) => failing.includes(id);
  if (entries.length < 2) return null;
  const text = "failed in " + entries.filter(fails).length + " of the last " + entries.length + " complete sessions";
  const dot = (entry) => h("span", { class: fails(entry) ? "negative" : "positive", title: entry.began + (fails(entry) ? ": failed" : ": did not fail") }, fails(entry) ? "✗" : "●");
  return section("In earlier sessions", h("p", { class: "dots", role: "img", "aria-label": text }, entries.map((entry) => [dot(entry), " "])),
    h("p", { class: "soft small" }, capitalized(text) + ", the latest at the right."));
}

TEST_SECTIONS.last.push((_, test) => DATA.history && historyDots(test.id));
