// Elements get their text as text nodes only, so that no name in a report can become a tag.

const INVISIBLE = /[\p{Cc}\p{Cf}\p{Cs}\p{Zl}\p{Zp}]/gu;

/** Text with control, format and surrogate characters written as escapes: no name can pass for another. */
function visible(text) {
  return String(text).replace(INVISIBLE, (char) =>
    char === "\n" || char === "\t" ? char : "\\u{" + char.codePointAt(0).toString(16) + "}");
}

// Of an address that leads away from the page's folder, or is a script: a scheme, a host, a root, a step upwards.
const LEADS_AWAY = /^[^#]*?[\\:]|^\/|^(?:[^#]*\/)?\.\.(?:[\/#?]|$)/;

/** An address of the page, or of a file beside it; null for any other, which then is no link. */
function inside(address) {
  return LEADS_AWAY.test(address) ? null : address;
}

/** An element; children are elements, texts, or lists of them; null and false are left out. */
function h(tag, attributes, ...children) {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes || {})) {
    if (name.startsWith("on")) element.addEventListener(name.slice(2), value);
    else if ((name === "href" || name === "src") && inside(value) === null) continue;
    else if (value === true) element.setAttribute(name, "");
    else if (value !== null && value !== undefined && value !== false) element.setAttribute(name, visible(value));
  }
  for (const child of children.flat(Infinity)) {
    if (child === null || child === undefined || child === false) continue;
    element.append(child instanceof Node ? child : visible(child));
  }
  return element;
}

/** A table of rows; heads are texts, or [text, class] each; false ones are left out. */
function tableOf(attributes, heads, rows) {
  const cells = heads.filter(Boolean).map((head) => [head].flat()).map(([text, style]) => h("th", { scope: "col", class: style }, text));
  return h("table", attributes, h("thead", {}, h("tr", {}, cells)), h("tbody", {}, rows));
}

function capitalized(text) {
  return text.charAt(0).toUpperCase() + text.slice(1);
}

/** A name of at most so many characters: cut in the middle, as names often differ at their ends only. */
function shortened(name, most) {
  const kept = most - 1, start = Math.floor(kept / 2);
  return name.length <= most ? name : name.slice(0, start) + "…" + name.slice(name.length - (kept - start));
}

/** `nurse`, `nurse and child`, `nurse, porter and child`. */
function enumerated(names) {
  return [names.slice(0, -1).join(", "), ...names.slice(-1)].filter(Boolean).join(" and ");
}

function percent(value) {
  if (value === null) return "-";
  const least = value > 0 ? 0.1 : 0, most = value < 100 ? 99.9 : 100;
  return Math.min(Math.max(value, least), most).toFixed(1) + " %";
}

function seconds(value) {
  if (value === null) return "-";
  return value.toFixed(Math.abs(value) < 10 ? 2 : Math.abs(value) < 1000 ? 1 : 0) + " s";
}

function outcomeBadge(outcome) {
  return h("span", { class: "badge " + DATA.outcomeStyles[outcome] }, DATA.outcomeWords[outcome]);
}

const VERDICTS = {
  P: ["✓", "Passed", "positive"], F: ["✗", "Failed", "negative"], K: ["✗", "Failed, as is known", "known"],
  N: ["NC", "NC: not checked", "soft"],
};

function verdictMark(letter) {
  const [sign, title, style] = VERDICTS[letter] || ["-", "not monitored", "soft"];
  return h("span", { class: style, title }, sign);
}

const natural = new Intl.Collator("en", { numeric: true }).compare;
