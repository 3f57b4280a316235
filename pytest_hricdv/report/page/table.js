// Tables that can be sorted; a long one has only the rows in sight in the page, so that it scrolls smoothly.

// Rows above and below those in sight that are drawn, too. Chosen: fewer would be seen coming when one scrolls fast; more
// take longer to draw than a frame lasts.
const SPARE_ROWS = 24;
// At first so many are drawn, as the height of a row is not known yet: a screen of them.
const FIRST_ROWS = 30;
// A table of at most so many rows is drawn whole, so that the browser's own search finds them all; but the rest of it only
// when nobody has gone on to something else for a moment. Chosen: more than the tests of a suite, and sooner than one reads.
const WHOLE_ROWS = 150;
const REST_AFTER_MS = 400;

/**
 * A table over `rows` of equal height, in a box that scrolls, with its head and first column always in sight. `columns`:
 * {key, title, value(row) to sort by, cell(row), style, heading}; `kept` (row -> bool) and `order` ([key, descending])
 * may be changed before `draw()`; `sorted` is called when a heading was clicked, and draws.
 */
class Table {
  constructor(columns, rows, label) {
    this.columns = columns;
    this.rows = rows;
    this.kept = () => true;
    this.order = null;
    this.sorted = () => {};
    this.shown = [];
    this.first = this.last = this.wanted = 0;
    this.waits = null;
    this.head = h("tr");
    this.above = h("tr", { "aria-hidden": "true" }, h("td", { colspan: columns.length }));
    this.below = h("tr", { "aria-hidden": "true" }, h("td", { colspan: columns.length }));
    this.body = h("tbody");
    this.count = h("p", { class: "soft small", "aria-live": "polite", id: "shown" });
    this.table = h("table", { class: "list", "aria-label": label }, h("thead", {}, this.head), this.body);
    this.box = h("div", { class: "card flat rows", tabindex: 0, role: "region", "aria-label": label }, this.table);
    this.element = h("div", {}, this.box, this.count);
    this.box.addEventListener("scroll", () => this.drawRows(), { passive: true });
    new ResizeObserver(() => { if (this.body.firstChild) this.drawRows(); }).observe(this.box);
    addEventListener("beforeprint", () => { this.wanted = this.shown.length; this.drawRows(); });
  }

  sortBy(key) {
    this.order = [key, this.order !== null && this.order[0] === key && !this.order[1]];
    this.sorted();
  }

  draw() {
    this.shown = this.rows.filter(this.kept);
    const column = this.order && this.columns.flatMap((each) => [each, ...(each.parts || [])]).find((each) => each.key === this.order[0]);
    if (column) sortRows(this.shown, column.value, this.order[1]);
    this.head.replaceChildren(...this.columns.map((each) => this.heading(each)));
    this.table.setAttribute("aria-rowcount", this.shown.length + 1);
    this.count.textContent = (this.shown.length < this.rows.length ? this.shown.length + " of " : "") + this.rows.length + (this.rows.length === 1 ? " test" : " tests");
    this.box.scrollTop = 0;
    this.first = this.last = this.wanted = 0;
    this.above.hidden = this.below.hidden = true;
    this.body.replaceChildren(this.above, this.below);
    this.drawRows();
  }

  toTop() {
    this.box.scrollTop = 0;
    this.drawRows();
  }

  /** Which rows have to be drawn, of a height in pixels. */
  window(height) {
    const count = this.shown.length;
    if (!height) return [0, Math.min(count, FIRST_ROWS)];
    const first = Math.floor(this.box.scrollTop / height), seen = Math.ceil(this.box.clientHeight / height);
    const last = Math.min(count, first + seen + SPARE_ROWS);
    return count <= WHOLE_ROWS ? [0, Math.max(last, this.last, Math.min(count, this.wanted))] : [Math.max(0, first - SPARE_ROWS), last];
  }

  /** The height of a row in sight; 0 where none is. */
  height() {
    const row = this.above.nextElementSibling;
    return row === null || row === this.below ? 0 : row.getBoundingClientRect().height;
  }

  /** Draws rows until those in sight, and some around them, are there; the rest of a short table a little later. */
  drawRows() {
    let height = this.height();
    if (this.last && !height) return; // it is not in sight
    let [first, last] = this.window(height);
    while (first !== this.first || last !== this.last) {
      this.replaceRows(first, last);
      height ||= this.height();
      for (const [row, count] of [[this.above, first], [this.below, this.shown.length - last]]) {
        row.hidden = count === 0;
        if (count) row.firstChild.style.height = count * height + "px";
      }
      if (!height) break;
      [first, last] = this.window(height);
    }
    if (height && this.shown.length <= WHOLE_ROWS && last < this.shown.length) this.drawRestLater();
  }

  drawRestLater() {
    clearTimeout(this.waits);
    this.waits = setTimeout(() => {
      this.wanted = this.shown.length;
      this.drawRows();
    }, REST_AFTER_MS);
  }

  /** Adds and takes away rows at both ends; those that stay are the same elements, so that the keyboard's place stays. */
  replaceRows(first, last) {
    const made = (from, to) => this.shown.slice(from, to).map((row, n) => this.row(row, from + n));
    if (first >= this.last || last <= this.first) {
      this.body.replaceChildren(this.above, ...made(first, last), this.below);
    } else {
      for (let n = this.first; n < first; n++) this.above.nextElementSibling.remove();
      for (let n = last; n < this.last; n++) this.below.previousElementSibling.remove();
      if (first < this.first) this.above.after(...made(first, this.first));
      if (last > this.last) this.below.before(...made(this.last, last));
    }
    [this.first, this.last] = [first, last];
  }

  row(row, place) {
    return h("tr", { "aria-rowindex": place + 2 }, this.columns.map((column) => h("td", { class: column.style }, column.cell(row))));
  }

  heading(column) {
    const parts = column.parts && column.parts.map((part) => this.sorter(part, -1));
    return h("th", { class: column.style, "aria-sort": this.sortOf(column), scope: "col" },
      parts ? h("span", { class: "strip" }, parts) : this.sorter(column, 0));
  }

  sortOf({ key }) {
    return this.order && this.order[0] === key ? (this.order[1] ? "descending" : "ascending") : null;
  }

  sorter(column, tabindex) {
    const mine = this.sortOf(column);
    return h("button", { type: "button", tabindex, class: "sort" + (mine ? " " + mine : ""), title: column.note, onclick: () => this.sortBy(column.key) }, column.head || column.title);
  }
}

/** Sorts in place; rows without a value (null) stay at the end either way. */
function sortRows(rows, value, descending) {
  const sign = descending ? -1 : 1;
  const keyed = rows.map((row, place) => ({ row, place, key: value(row) }));
  keyed.sort((a, b) => {
    if (a.key === null || b.key === null) return (a.key === null) - (b.key === null) || a.place - b.place;
    const by = typeof a.key === "number" ? a.key - b.key : natural(a.key, b.key);
    return sign * by || a.place - b.place;
  });
  keyed.forEach((each, place) => { rows[place] = each.row; });
}

/** Makes a table of the page's HTML sortable by a click on a heading; each of its groups by itself. */
function makeSortable(table) {
  [...table.tHead.rows[0].cells].forEach((heading, column) => {
    const button = h("button", { type: "button", class: "sort" }, heading.textContent);
    heading.replaceChildren(button);
    button.addEventListener("click", () => {
      const descending = heading.getAttribute("aria-sort") === "ascending";
      for (const body of table.tBodies) {
        const rows = [...body.rows].filter((row) => !row.classList.contains("group"));
        sortRows(rows, (row) => cellValue(row.cells[column]), descending);
        body.append(...rows);
      }
      for (const other of table.tHead.rows[0].cells) other.removeAttribute("aria-sort");
      heading.setAttribute("aria-sort", descending ? "descending" : "ascending");
    });
  });
}

function cellValue(cell) {
  const text = cell.textContent.trim();
  if (text === "-" || text === "") return null;
  return cell.classList.contains("n") ? parseFloat(text) : text;
}
