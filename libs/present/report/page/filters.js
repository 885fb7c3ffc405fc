// Filters of long tables: rows by the values in some of their columns, and with those of the first column the thin
// curves that bear its names. Without this script all rows are there.
function choiceOf(table, column, apply) {
  const values = [...new Set([...table.tBodies[0].rows].map(row => row.cells[column].textContent))];
  if (values.length < 2) return null;
  const heading = table.tHead.rows[0].cells[column].textContent;
  const label = document.createElement('label'), select = document.createElement('select');
  select.append(new Option('all', ''), ...values.map(value => new Option(value || '\u2013', value || '\u2013')));
  select.addEventListener('change', apply);
  label.append(heading, ' ', select);
  return {column, label, select};
}

// Of all charts; the thin curves of others step aside while one name is asked for.
function showCurvesOf(name) {
  if (typeof Chart === 'undefined') return;
  for (const canvas of document.querySelectorAll('figure.chart canvas')) {
    const chart = Chart.getChart(canvas);
    const thin = chart.data.datasets.map(dataset => dataset.series?.mark === 'thin');
    const has = chart.data.datasets.some((dataset, i) => thin[i] && dataset.label === name);
    thin.forEach((is, i) => is && chart.setDatasetVisibility(i, !has || chart.data.datasets[i].label === name));
    if (thin.includes(true)) chart.update('none');
  }
}

function addFilters(box) {
  const table = box.querySelector('table'), rows = [...table.tBodies[0].rows], count = document.createElement('output');
  const apply = event => {
    const chosen = choices.filter(({select}) => select.value);
    for (const row of rows)
      row.hidden = chosen.some(({column, select}) => (row.cells[column].textContent || '\u2013') !== select.value);
    count.textContent = `${rows.filter(row => !row.hidden).length} of ${rows.length} rows`;
    if (event && event.target === choices[0].select) showCurvesOf(event.target.value);
  };
  const choices = box.dataset.filters.split(' ').map(column => choiceOf(table, Number(column), apply)).filter(Boolean);
  if (!choices.length) return;
  const bar = document.createElement('div');
  bar.className = 'filters';
  bar.append(...choices.map(({label}) => label), count);
  box.before(bar);
  apply();
}

document.querySelectorAll('[data-filters]').forEach(addFilters);
