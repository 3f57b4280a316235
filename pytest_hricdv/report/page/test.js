// The page of a test: from its beliefs to what happened, and how to run it again.

function section(title, ...children) {
  return h("section", { class: "card" }, h("h3", {}, title), children);
}

function command(text) {
  const copied = h("button", { type: "button", onclick: () => {
    navigator.clipboard.writeText(text).then(() => { copied.textContent = "Copied"; }, () => { copied.textContent = "Select and copy it"; });
  } }, "Copy");
  return h("div", { class: "command" }, h("pre", {}, text), copied);
}

function chips(names) {
  return names.length
    ? h("ul", { class: "chips mono" }, names.map((name) => h("li", {}, name)))
    : h("p", { class: "soft" }, "none");
}

function verdictTable(verdicts) {
  return h("table", { class: "verdicts" }, h("thead", {}, h("tr", {}, ["", "Verdict", "Triggers", "Least margin"].map((each) => h("th", {}, each)))),
    h("tbody", {}, verdicts.map((verdict) => h("tr", {},
      h("td", {}, h("a", { href: "#requirement/" + encodeURIComponent(verdict.name) }, verdict.name)),
      h("td", { class: "nowrap" }, verdictMark(verdict.verdict === "NC" ? "N" : verdict.verdict[0]), " ", verdict.verdict === "NC" ? "" : verdict.verdict),
      h("td", { class: "wide small" }, verdict.counts, verdict.violations.map((text) => [h("br"), h("strong", {}, text)]),
        verdict.more > 0 && [h("br"), "and " + verdict.more + " more"],
        verdict.miss && [h("br"), h("span", { class: "soft" }, verdict.miss)]),
      h("td", { class: "small nowrap" }, verdict.margin || "-")))));
}

/** Abstract and concrete test side by side: what people do, and with which parameters. */
function actionTable(found) {
  const count = Math.max(found.abstract.length, found.actions.length);
  if (!count) return h("p", { class: "soft" }, "No action.");
  const times = found.acted.length > 0;
  const rows = Array.from({ length: count }, (_, n) => {
    const [name, parameters] = found.actions[n] || ["", ""], abstract = found.abstract[n];
    const concrete = abstract === name || !name ? parameters : name + " " + parameters;
    return h("tr", {}, h("td", { class: "n soft" }, n + 1), times && h("td", { class: "n soft" }, typeof found.acted[n] === "number" ? seconds(found.acted[n]) : "not done"), h("td", { class: "mono" }, abstract || "-"), h("td", { class: "mono wide" }, concrete));
  });
  const run = h("tr", {}, h("td"), times && h("td"), h("td", { class: "soft" }, "run"), h("td", { class: "mono wide" }, found.run));
  return h("table", { class: times ? "actions timed" : "actions" }, h("thead", {}, h("tr", {}, h("th", { class: "n" }, ""), times && h("th", { class: "n" }, "At"), h("th", {}, "Abstract test"), h("th", {}, "Concrete test"))), h("tbody", {}, rows, run));
}

function neighbours(test) {
  const link = (other, text) => other && h("a", { href: "#test/" + other.anchor, title: other.id }, text);
  return h("p", { class: "neighbours" }, link(TESTS[test.number - 1], "← previous"), " ", h("a", { href: "#tests" }, "all tests"), " ", link(TESTS[test.number + 1], "next →"));
}

function testView(test, found) {
  const plans = Object.entries(found.plans).map(([agent, labels]) =>
    [h("h4", {}, agent + " (" + labels.length + ")"), chips(labels)]);
  return [
    h("p", { class: "small soft" }, found.aim && found.aim + " · ", h("span", { class: "mono" }, found.nodeid)),
    found.repeats > 0 && h("p", { class: "notice mild" }, "The " + (found.repeats + 1) + " runs of this test differ; the worst is shown."),
    found.faults.length > 0 && section("Faults", h("ul", {}, found.faults.map((text) => h("li", {}, text)))),
    found.failure && section("Failure", h("pre", {}, found.failure)),
    found.replayed && h("p", { class: "notice mild" }, found.replayed),
    found.changed && behaviourView(found),
    section("Verdicts", h("div", { class: "scroll" }, verdictTable(found.verdicts))),
    TEST_SECTIONS.first.map((show) => show(found)),
    h("ol", { class: "steps" },
      h("li", {}, section("Beliefs", chips(found.beliefs))),
      h("li", {}, section("Plans they trigger", plans.length ? plans : h("p", { class: "soft" }, "none"))),
      h("li", {}, section("What " + (actorsOf(found.abstract).join(" and ") || "the human") + (actorsOf(found.abstract).length > 1 ? " do" : " does"), h("div", { class: "scroll" }, actionTable(found)))),
      h("li", {}, section("What happened", timelineView(found)))),
    TEST_SECTIONS.last.map((show) => show(found)),
    section("Run it again", found.rerun.map((line) => (line.startsWith("pytest ") ? command(line) : h("p", { class: "soft small" }, line)))),
    section("Run", h("dl", { class: "facts" }, Object.entries(found.facts).map(([name, value]) =>
      h("div", {}, h("dt", {}, name), h("dd", {}, value))))),
    neighbours(test),
  ];
}

async function testPage(view, anchor) {
  const test = BY_ANCHOR.get(anchor);
  if (!test) {
    view.replaceChildren(h("p", { class: "card" }, "There is no such test in this report. ", h("a", { href: "#tests" }, "All tests")));
    return;
  }
  view.dataset.test = anchor;
  const heading = h("h2", {}, test.id, " ", outcomeBadge(test.outcome), h("span", { class: "soft small" }, " suite " + DATA.suites[test.suite]));
  view.replaceChildren(heading, h("p", { class: "soft" }, "Loading ..."));
  let shown;
  try {
    shown = testView(test, await details(test));
  } catch (error) {
    shown = [h("p", { class: "notice" }, "The details of this test cannot be shown: " + error.message)];
  }
  // Another test may have been opened meanwhile.
  if (view.dataset.test === anchor) view.replaceChildren(heading, ...shown.flat().filter(Boolean));
}
