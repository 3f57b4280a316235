// The page of a test: from its beliefs to what happened, and how to run it again.

function section(title, ...children) {
  return h("section", { class: "card" }, h("h3", {}, title), children);
}

function command(text) {
  return h("div", { class: "command" }, h("pre", {}, text), copyButton("Copy", () => text));
}

function chips(names) {
  return names.length
    ? h("ul", { class: "chips mono" }, names.map((name) => h("li", {}, name)))
    : h("p", { class: "soft" }, "none");
}

function verdictTable(verdicts) {
  return tableOf({ class: "verdicts" }, ["Requirement", "Verdict", "Triggers", "Least margin"],
    verdicts.map((verdict) => h("tr", {},
      h("td", {}, h("a", { href: "#requirement/" + encodeURIComponent(verdict.name) }, verdict.name)),
      h("td", { class: "nowrap" }, verdictMark(verdict.verdict === "NC" ? "N" : verdict.verdict[0]), " ", verdict.verdict === "NC" ? "" : verdict.verdict),
      h("td", { class: "wide small" }, verdict.counts, verdict.violations.map((text) => [h("br"), h("strong", {}, text)]),
        verdict.more > 0 && [h("br"), "and " + verdict.more + " more"],
        verdict.miss && [h("br"), h("span", { class: "soft" }, verdict.miss)]),
      h("td", { class: "small nowrap" }, verdict.margin || "-"))));
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
  return tableOf({ class: times ? "actions timed" : "actions" }, [["No.", "n"], times && ["At", "n"], "Abstract test", "Concrete test"], [rows, run]);
}

function neighbours(test) {
  const link = (other, text) => other && h("a", { href: "#test/" + other.anchor, title: other.id }, text);
  return h("p", { class: "neighbours" }, link(TESTS[test.number - 1], "← previous"), " ", h("a", { href: "#tests" }, "all tests"), " ", link(TESTS[test.number + 1], "next →"));
}

/** The tests that "previous failure" and "next failure" lead through; from one whose violations are known, all of those, too. */
function failuresAround(test) {
  const isBad = (other) => DATA.outcomeStyles[other.outcome] === "bad" || other.verdicts.includes("F");
  const withKnown = !isBad(test) && test.verdicts.includes("K");
  return TESTS.filter((other) => isBad(other) || (withKnown && other.verdicts.includes("K")));
}

/** Links to the failing tests before and after this one, and how many there are. */
function failureLinks(test) {
  const failing = failuresAround(test), place = failing.indexOf(test);
  const before = failing.findLast((other) => other.number < test.number), after = failing.find((other) => other.number > test.number);
  if (!before && !after) return null;
  const link = (other, name, text) => other && h("a", { href: "#test/" + other.anchor, "data-failure": name, title: other.id }, text);
  return h("p", { class: "neighbours failing small" }, link(before, "p", "‹ previous failure"),
    h("span", { class: "soft" }, place < 0 ? plural(failing.length, "failing test") : "failing test " + (place + 1) + " of " + failing.length),
    link(after, "n", "next failure ›"));
}

function plural(count, noun) {
  return count + " " + noun + (count === 1 ? "" : "s");
}

/** What failed, before everything else: each requirement with its title, when, by how much, and its formula. */
function failedList(test, found) {
  const failed = failedVerdicts(found).sort((a, b) => (a.times[0] ?? Infinity) - (b.times[0] ?? Infinity));
  const at = (time) => h("a", { href: "#test/" + test.anchor + "@" + time, onclick: (event) => {
    if (!openRun) return;
    event.preventDefault();
    openRun.go(time);
  } }, "at " + seconds(time));
  const item = (verdict) => h("li", {},
    h("strong", { class: "negative" }, h("a", { href: "#requirement/" + encodeURIComponent(verdict.name) }, verdict.name), " failed"), test.verdicts[DATA.requirements.indexOf(verdict.name)] === "K" && [" ", h("span", { class: "badge warn" }, "known")], " ",
    verdict.times.slice(0, 3).map((time, n) => [n ? ", " : "", at(time)]), verdict.times.length + verdict.more > 3 && " and " + (verdict.times.length + verdict.more - 3) + " times more",
    verdict.margin && h("span", { class: "soft" }, " · worst margin " + verdict.margin),
    h("div", {}, textsOf(verdict.name).title, " ", textsOf(verdict.name).formula && h("details", { class: "small soft" }, h("summary", {}, "formula"), h("pre", {}, textsOf(verdict.name).formula))));
  if (!failed.length && !found.faults.length) return null;
  return h("section", { class: "card failed", "aria-label": "What failed" }, failed.length > 0 && h("ul", {}, failed.map(item)),
    found.faults.length > 0 && h("ul", {}, found.faults.map((text) => h("li", {}, h("strong", { class: "negative" }, "Fault: "), text))),
    causeLines(test, found));
}

/** Verdicts with those that failed first. */
function failedFirst(verdicts) {
  return [...verdicts].sort((a, b) => Number(b.verdict === "Failed") - Number(a.verdict === "Failed"));
}

function testView(test, found, time) {
  const plans = Object.entries(found.plans).map(([agent, labels]) =>
    [h("h4", {}, agent + " (" + labels.length + ")"), chips(labels)]);
  return [
    found.repeats > 0 && h("p", { class: "notice mild" }, "The " + (found.repeats + 1) + " runs of this test differ; the worst is shown."),
    failedList(test, found),
    runSection(test, found, time),
    found.replayed && h("p", { class: "notice mild" }, found.replayed),
    found.changed && behaviourView(found),
    section("Verdicts", h("div", { class: "scroll" }, verdictTable(failedFirst(found.verdicts)))),
    TEST_SECTIONS.first.map((show) => show(found, test)),
    h("ol", { class: "steps" },
      h("li", {}, section("Beliefs", chips(found.beliefs))),
      h("li", {}, section("Plans they trigger", plans.length ? plans : h("p", { class: "soft" }, "none"))),
      h("li", {}, section("What " + (enumerated(actorsOf(found.abstract)) || "the human") + (actorsOf(found.abstract).length > 1 ? " do" : " does"), h("div", { class: "scroll" }, actionTable(found))))),
    TEST_SECTIONS.last.map((show) => show(found, test)),
    found.failure && h("details", { class: "card" }, h("summary", {}, h("h3", {}, "Failure, as in the terminal")), h("pre", {}, found.failure)),
    section("Run it again", found.rerun.map((line) => (line.startsWith("pytest ") ? command(line) : h("p", { class: "soft small" }, line)))),
    section("Run", h("p", { class: "small soft" }, found.aim && found.aim + " · ", h("span", { class: "mono" }, found.nodeid)), h("dl", { class: "facts" }, Object.entries(found.facts).map(([name, value]) =>
      h("div", {}, h("dt", {}, name), h("dd", {}, value))))),
    neighbours(test),
  ];
}

/** The test, and the time (s) or null, that an address names: a digest or an id, and the time after "@". */
function testAt(rest) {
  const of = (name) => BY_ANCHOR.get(name) ?? TESTS.find((test) => test.id === name);
  const [, name, time] = /^(.*)@(\d+(?:\.\d+)?)$/.exec(rest) ?? [null, rest, null];
  const timed = time !== null && of(name);
  return timed ? { test: timed, time: Number(time) } : { test: of(rest), time: null };
}

function unescaped(address) {
  try { return decodeURIComponent(address); } catch { return address; }
}

async function testPage(view) {
  const { test, time } = testAt(unescaped(location.hash.replace(/^#test\//, "")));
  if (!test) {
    view.replaceChildren(h("p", { class: "card" }, "There is no such test in this report. ", h("a", { href: "#tests" }, "All tests")));
    return;
  }
  const { anchor } = test;
  view.dataset.test = anchor;
  const heading = [h("h2", {}, test.id, " ", outcomeBadge(test.outcome), h("span", { class: "soft small" }, " suite " + DATA.suites[test.suite])), failureLinks(test)].filter(Boolean);
  const loading = h("p", { class: "soft" }, "Loading ...");
  view.replaceChildren(...heading, loading);
  let shown;
  try {
    const found = await details(test);
    // Another test may have been opened meanwhile.
    if (view.dataset.test !== anchor) return;
    shown = testView(test, found, time);
  } catch (error) {
    shown = [h("p", { class: "notice" }, "The details of this test cannot be shown: " + error.message)];
  }
  // The heading stays where it is: it has the keyboard's place, and a link in it may be being clicked.
  if (view.dataset.test === anchor) loading.replaceWith(...shown.flat().filter(Boolean));
}

document.addEventListener("keydown", (event) => {
  const link = document.querySelector("#test:not([hidden]) [data-failure=" + (event.key === "n" || event.key === "p" ? event.key : "none") + "]");
  if (!link || event.ctrlKey || event.metaKey || event.altKey || event.target.closest("input, select, textarea")) return;
  link.click();
});
