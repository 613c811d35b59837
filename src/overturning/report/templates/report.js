"use strict";
// Tables with class "sortable": a click, or Enter, on a heading sorts by its column; numbers as numbers, dashes last.
document.querySelectorAll("table.sortable").forEach(function (table) {
  const body = table.tBodies[0];
  function key(row, column) {
    const text = row.cells[column].textContent.replace(/−/g, "-").trim();
    const number = parseFloat(text.replace(/^[^0-9.-]+/, "").replace(/(\d),(?=\d{3}\b)/g, "$1"));  // 12,345 is one
    return { text: text, number: /\d/.test(text) ? number : NaN, empty: text === "–" || text === "" };
  }
  Array.from(table.tHead.rows[0].cells).forEach(function (heading, column) {
    heading.setAttribute("tabindex", "0");
    heading.setAttribute("aria-sort", "none");
    function sort() {
      const down = heading.getAttribute("aria-sort") === "ascending";
      const rows = Array.from(body.rows).map(function (row) { return { row: row, key: key(row, column) }; });
      const numeric = heading.classList.contains("n");
      rows.sort(function (a, b) {
        if (a.key.empty !== b.key.empty) return a.key.empty ? 1 : -1;
        const order = numeric ? a.key.number - b.key.number : a.key.text.localeCompare(b.key.text, "en");
        return down ? -order : order;
      });
      rows.forEach(function (entry) { body.appendChild(entry.row); });
      Array.from(heading.parentNode.cells).forEach(function (other) { other.setAttribute("aria-sort", "none"); });
      heading.setAttribute("aria-sort", down ? "descending" : "ascending");
    }
    heading.addEventListener("click", sort);
    heading.addEventListener("keydown", function (event) { if (event.key === "Enter") sort(); });
  });
});
// A link to a folded chapter opens the folds around it.
function openFolds() {
  const target = document.getElementById(decodeURIComponent(location.hash.slice(1)));
  for (let node = target; node; node = node.parentElement) if (node.tagName === "DETAILS") node.open = true;
  if (target) target.scrollIntoView();
}
window.addEventListener("hashchange", openFolds);
if (location.hash) openFolds();
