// Tables that can be sorted, searched and paged.

const PAGE_ROWS = 100;

/**
 * A table over `rows`. `columns`: {title, value(row) to sort by, cell(row), number, style}; `kept` (row -> bool) and
 * `order` ([column, descending]) may be changed before `draw()`.
 */
class Table {
  constructor(columns, rows) {
    this.columns = columns;
    this.rows = rows;
    this.kept = () => true;
    this.order = null;
    this.page = 0;
    this.head = h("tr");
    this.body = h("tbody");
    this.count = h("span", { class: "soft small", "aria-live": "polite", id: "shown" });
    this.back = h("button", { type: "button", onclick: () => this.turn(-1) }, "Back");
    this.forward = h("button", { type: "button", onclick: () => this.turn(1) }, "More");
    this.element = h("div", { class: "turned" },
      h("div", { class: "card scroll flat" }, h("table", { class: "list" }, h("thead", {}, this.head), this.body)),
      h("p", { class: "pager" }, this.count, this.back, this.forward));
  }

  turn(pages) {
    this.page += pages;
    this.draw();
    this.element.scrollIntoView();
  }

  sortBy(number) {
    const descending = this.order && this.order[0] === number ? !this.order[1] : false;
    this.order = [number, descending];
    this.page = 0;
    this.draw();
  }

  draw() {
    const rows = this.rows.filter(this.kept);
    if (this.order) sortRows(rows, this.columns[this.order[0]].value, this.order[1]);
    this.page = Math.max(0, Math.min(this.page, Math.ceil(rows.length / PAGE_ROWS) - 1));
    const first = this.page * PAGE_ROWS, shown = rows.slice(first, first + PAGE_ROWS);
    this.head.replaceChildren(...this.columns.map((column, number) => this.heading(column, number)));
    this.body.replaceChildren(...shown.map((row) =>
      h("tr", {}, this.columns.map((column) => h("td", { class: column.style }, column.cell(row))))));
    const range = rows.length > PAGE_ROWS ? (first + 1) + " to " + (first + shown.length) + " of " : "";
    const all = rows.length < this.rows.length ? " of " + this.rows.length : "";
    this.count.textContent = range + rows.length + all + (this.rows.length === 1 ? " test" : " tests");
    this.back.hidden = this.page === 0;
    this.forward.hidden = first + shown.length >= rows.length;
  }

  heading(column, number) {
    const mine = this.order && this.order[0] === number;
    const sort = mine ? (this.order[1] ? "descending" : "ascending") : null;
    const button = h("button", { type: "button", class: "sort", onclick: () => this.sortBy(number) }, column.title);
    return h("th", { class: column.style, "aria-sort": sort, scope: "col" }, button);
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
