'use strict';
(() => {
  const find = (id) => document.getElementById(id);
  const [tools, filter, order, shown, none] = ['tools', 'filter', 'order', 'shown', 'no-law'].map(find);
  const table = document.querySelector('table.verdicts');
  const body = table.tBodies[0];
  const rows = Array.from(body.rows);
  // Raised digits are found by plain ones: ⁻¹ by −1.
  const plain = (text) => text.normalize('NFKC').toLowerCase();
  const texts = new Map(rows.map((row) => [row, plain(row.cells[0].textContent)]));
  const heads = Array.from(table.querySelectorAll('th[data-key]'));
  const ascending = new Set(['place', 'name']);

  const filtered = () => {
    const words = plain(filter.value).split(/\s+/).filter(Boolean);
    let count = 0;
    for (const row of rows) {
      row.hidden = !words.every((word) => texts.get(row).includes(word));
      count += row.hidden ? 0 : 1;
    }
    shown.textContent = count + ' of ' + rows.length;
    none.hidden = count > 0;
  };

  // The first key decides; rows that agree in it stay as the page has them.
  const ordered = () => {
    const key = order.value;
    const value = (row) => (key === 'name' ? row.dataset.name : Number(row.dataset[key]));
    const compare = (a, b) => (value(a) < value(b) ? -1 : value(a) > value(b) ? 1 : 0);
    const sign = ascending.has(key) ? 1 : -1;
    const place = (row) => Number(row.dataset.place);
    rows.slice().sort((a, b) => sign * compare(a, b) || place(a) - place(b)).forEach((row) => body.append(row));
    for (const head of heads) {
      const chosen = head.dataset.key === key;
      head.setAttribute('aria-sort', chosen ? (sign > 0 ? 'ascending' : 'descending') : 'none');
    }
  };

  for (const head of heads) {
    const button = document.createElement('button');
    button.type = 'button';
    button.append(...head.childNodes);
    button.addEventListener('click', () => {
      order.value = order.value === head.dataset.key ? 'place' : head.dataset.key;
      ordered();
    });
    head.append(button);
  }
  // A law that a link leads to is never hidden.
  addEventListener('hashchange', () => {
    const target = find(decodeURIComponent(location.hash.slice(1)));
    if (target && target.hidden) {
      filter.value = '';
      filtered();
      target.scrollIntoView();
    }
  });
  tools.addEventListener('submit', (event) => event.preventDefault());
  filter.addEventListener('input', filtered);
  order.addEventListener('change', ordered);
  tools.hidden = false;
  filtered();
  ordered();
})();
