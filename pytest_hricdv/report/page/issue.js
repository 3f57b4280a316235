// A failing test as the text of an issue, in Markdown: what happened, what was expected, its cause, how to repeat it.

/** A block of code, within more backquotes than the text has. */
function fenced(text) {
  const longest = Math.max(2, ...(text.match(/`+/g) ?? []).map((each) => each.length)), fence = "`".repeat(longest + 1);
  return fence + "\n" + text + "\n" + fence;
}

/** What people do, each with its time where the run came so far. */
function issueSteps({ abstract, acted, actions }) {
  return abstract.map((line, n) => {
    const parameters = actions[n] && actions[n][1], time = typeof acted[n] === "number" ? seconds(acted[n]) + ": " : acted.length ? "not done: " : "";
    return n + 1 + ". " + time + "`" + line + "`" + (parameters ? " (" + parameters + ")" : "");
  }).join("\n");
}

function issueText(test, found) {
  const failed = failedVerdicts(found), names = enumerated(failed.map((verdict) => verdict.name));
  const expected = failed.map(({ name }) => [name, textsOf(name).title, textsOf(name).formula].filter(Boolean).join("\n"));
  const seen = [...failed.flatMap((verdict) => verdict.violations), ...found.faults];
  const part = (title, text) => text && "### " + title + "\n\n" + text;
  return visible([
    "## " + (names ? names + " fails" : "Error") + " in " + test.id,
    part("Steps", issueSteps(found)),
    part("Expected", expected.length && fenced(expected.join("\n\n"))),
    part("Seen", seen.length && fenced(seen.join("\n"))),
    ...causesOf(test).map((cause) => part("Cause", fenced([cause.title, ...cause.lines].join("\n")))),
    part("Repeat", fenced(found.rerun.filter((line) => line.startsWith("pytest ")).join("\n"))),
    DATA.made && "Made with " + DATA.made + ".",
  ].filter(Boolean).join("\n\n")) + "\n";
}

/** The causes that a test fails for, where somebody looked for them. */
function causesOf(test) {
  return DATA.failedFor.filter((cause) => cause.tests.includes(test.number));
}

/** A button that copies a text, and says so. */
function copyButton(label, text) {
  const button = h("button", { type: "button", onclick: () => {
    navigator.clipboard.writeText(text()).then(() => { button.textContent = "Copied"; }, () => { button.textContent = "It cannot be copied here"; });
  } }, label);
  return button;
}

/** What a failing test fails for, the command that runs it again, and its text for an issue. */
function causeLines(test, found) {
  const again = found.rerun.find((line) => line.startsWith("pytest "));
  return [
    causesOf(test).map((cause) => h("p", { class: "small" }, h("a", { href: "#" + cause.anchor }, cause.title), cause.decides && [": ", cause.decides])),
    again && command(again),
    h("p", { class: "small" }, copyButton("Copy as issue", () => issueText(test, found)), h("span", { class: "soft" }, " as Markdown: steps, expected, seen, cause, how to repeat it")),
  ];
}
