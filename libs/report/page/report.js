// Draws the charts of a report with Chart.js: each <figure class="chart"> holds a canvas and its data as JSON.
'use strict';
(() => {
const INK = '#222222', QUIET = '#666666', GRID = '#ececec', SHADE = '#f1f1f1';
const DASHES = {line: [], thin: [], dashed: [8, 5], dotted: [2, 4], points: []};
const WIDTHS = {line: 2.25, thin: 1, dashed: 2.25, dotted: 2.25, points: 1};
const dataOf = new WeakMap();  // of each chart's canvas
const WHEEL_STEP = 1.2, BUTTON_STEP = 1.5, LEAST_BOX_PX = 8;
const MANY = 60;  // points that are drawn small
const NEGLIGIBLE = 0.02;  // of the longest bar: so little below zero is not worth a tick
const VALUE_PX = 44;  // room for a value beside its bar

const withAlpha = (colour, alpha) => colour + Math.round(alpha * 255).toString(16).padStart(2, '0');
const minus = text => text.replace('-', '\u2212');
const digits = value => minus(String(Number(value.toPrecision(4))));
const fixed = decimals => value => minus(value.toFixed(decimals));

// ---- line charts

function bandOf(series) {
  const edge = values => series.x.map((x, i) => ({x, y: values[i]}));
  const hidden = {pointRadius: 0, pointHoverRadius: 0, borderWidth: 0, isBand: true, order: 2};
  return [
    {...hidden, label: series.name, data: edge(series.lower)},
    {...hidden, label: series.name, data: edge(series.upper), fill: '-1',
     backgroundColor: withAlpha(series.colour, 0.2)},
  ];
}

function lineOf(series) {
  const points = series.mark === 'points';
  return {
    label: series.name, data: series.x.map((x, i) => ({x, y: series.y[i]})), series, order: points ? 0 : 1,
    borderColor: series.colour, backgroundColor: series.colour, borderDash: DASHES[series.mark],
    showLine: !points, borderWidth: WIDTHS[series.mark], pointRadius: !points ? 0 : series.x.length > MANY ? 2 : 4, pointHoverRadius: 5,
    pointStyle: points ? 'rectRot' : 'circle', borderJoinStyle: 'round',
  };
}

const datasetsOf = data =>
  data.series.flatMap(series => [...(series.lower.length ? bandOf(series) : []), lineOf(series)]);

function hoverText(data, item) {
  const {series} = item.dataset, i = item.dataIndex, place = data.equal ? digits(item.parsed.x) + ', ' : '';
  const band = series.lower.length && series.lower[i] !== null && series.upper[i] !== null ?
    ` (${digits(series.lower[i])} to ${digits(series.upper[i])})` : '';
  return ` ${series.name}: ${place}${digits(item.parsed.y)}${band}`;
}

function hoverTitle(data, items) {
  if (!items.length) return '';
  const {dataset, dataIndex, parsed} = items[0];
  if (dataset.series.labels.length) return dataset.series.labels[dataIndex];
  return data.equal ? '' : `${data.x.label}: ${digits(parsed.x)}`;
}

// A click on a name hides its line and its band.
function toggleSeries(event, item, legend) {
  const chart = legend.chart, visible = chart.isDatasetVisible(item.datasetIndex);
  chart.data.datasets.forEach((dataset, i) => {
    if (dataset.label === item.text) chart.setDatasetVisibility(i, !visible);
  });
  chart.update();
}

function axisOf(axis, extra) {
  return {
    type: 'linear', min: axis.from ?? undefined, max: axis.to ?? undefined,
    title: {display: axis.label !== '', text: axis.label, color: INK},
    grid: {color: GRID, borderColor: QUIET, tickColor: QUIET, tickLength: 5},
    ticks: {color: INK, includeBounds: false, maxRotation: 0, callback: value => minus(String(Number(value.toPrecision(9))))},
    ...extra,
  };
}

// A function of x fills the width; the axis ends where the data do.
function dataRange(data) {
  const xs = data.series.flatMap(series => series.x).filter(x => x !== null);
  const ends = xs.reduce(([low, high], x) => [Math.min(low, x), Math.max(high, x)], [Infinity, -Infinity]);
  return data.equal || !(ends[0] < ends[1]) ? {} : {from: ends[0], to: ends[1]};
}

function lineConfig(data) {
  const range = dataRange(data);
  const x = {...data.x, from: data.x.from ?? range.from, to: data.x.to ?? range.to};
  return {
    type: 'line', data: {datasets: datasetsOf(data)},
    plugins: [background, intervals, verticalLines, zoomBox],
    options: {
      ...common(), interaction: {mode: 'nearest', axis: data.equal ? 'xy' : 'x', intersect: false},
      onResize: chart => chart.wanted && requestAnimationFrame(() => show(chart, chart.wanted)),
      scales: {x: axisOf(x), y: axisOf(data.y, {grace: data.equal ? '6%' : '4%'})},
      plugins: {
        legend: legendOf(data.series.length > 1, item => !item.isBand, toggleSeries),
        tooltip: {
          filter: item => !item.dataset.isBand && item.dataset.series.mark !== 'thin',
          callbacks: {title: items => hoverTitle(data, items), label: item => hoverText(data, item)},
        },
      },
    },
  };
}

// ---- bar charts

function barConfig(data) {
  const whole = fixed(data.decimals);
  const datasets = data.series.map(series => ({
    label: series.name, data: series.values, series, backgroundColor: series.colours, borderColor: series.colours,
    barPercentage: 0.8, categoryPercentage: 0.75, maxBarThickness: 44,
  }));
  const label = item => {
    const {lower, upper} = item.dataset.series, i = item.dataIndex;
    const ends = lower.length && lower[i] !== null ? ` (${whole(lower[i])} to ${whole(upper[i])})` : '';
    return ` ${item.dataset.label}: ${whole(item.parsed.x)}${ends}`;
  };
  const ends = data.series.flatMap(series => [...series.values, ...series.lower, ...series.upper, 0]);
  const low = Math.min(...ends), high = Math.max(...ends);
  const reach = {suggestedMin: low < -NEGLIGIBLE * high ? low : 0, suggestedMax: high};
  return {
    type: 'bar', data: {labels: data.categories, datasets}, plugins: [background, errorBars],
    options: {
      ...common(), indexAxis: 'y', layout: {padding: {right: VALUE_PX}}, interaction: {mode: 'nearest', axis: 'y', intersect: false},
      scales: {x: axisOf(data.x, reach), y: {grid: {display: false, borderColor: QUIET}, ticks: {color: INK}}},
      plugins: {legend: legendOf(data.series.length > 1, () => true), tooltip: {callbacks: {label}}},
    },
  };
}

const barHeight = data => `${5 + data.categories.length * Math.max(2.6, 1.7 * data.series.length)}rem`;

// ---- what both share

const common = () => ({
  responsive: true, maintainAspectRatio: false, animation: false,
  devicePixelRatio: Math.max(2, window.devicePixelRatio),  // sharp in print as well
});

const legendOf = (display, keep, onClick) => ({
  display, align: 'start', ...(onClick ? {onClick} : {}),
  labels: {
    color: INK, usePointStyle: true, pointStyleWidth: 26, boxHeight: 6,
    filter: (item, data) => keep(data.datasets[item.datasetIndex]),
    sort: (a, b) => a.datasetIndex - b.datasetIndex,
    generateLabels: chart => Chart.defaults.plugins.legend.labels.generateLabels(chart).map(item => {
      const {showLine, pointStyle, borderDash, borderWidth} = chart.data.datasets[item.datasetIndex];
      return showLine ? {...item, pointStyle: 'line', lineDash: borderDash, lineWidth: borderWidth} :
        {...item, pointStyle: pointStyle ?? 'rect', lineWidth: 0};
    }),
  },
});

const background = {
  id: 'background',
  beforeDraw({ctx, width, height}) {
    ctx.save();
    ctx.fillStyle = '#ffffff';
    ctx.fillRect(0, 0, width, height);
    ctx.restore();
  },
};

// Calls draw(ctx, area, toPixel) clipped to the chart's area.
function inArea(chart, draw) {
  const {ctx, chartArea: area, scales} = chart;
  ctx.save();
  ctx.beginPath();
  ctx.rect(area.left, area.top, area.width, area.height);
  ctx.clip();
  ctx.font = `11px ${Chart.defaults.font.family}`;
  draw(ctx, area, x => scales.x.getPixelForValue(x));
  ctx.restore();
}

const intervals = {
  id: 'intervals',
  beforeDatasetsDraw(chart) {
    inArea(chart, (ctx, area, pixel) => dataOf.get(chart.canvas).intervals.forEach(({from, to, label}) => {
      ctx.fillStyle = SHADE;
      ctx.fillRect(pixel(from), area.top, pixel(to) - pixel(from), area.height);
      ctx.fillStyle = QUIET;
      ctx.fillText(label, pixel(from) + 4, area.bottom - 6);
    }));
  },
};

// Labels that would cover each other stand one below the other.
const verticalLines = {
  id: 'verticalLines',
  beforeDatasetsDraw(chart) {
    const rowEnds = [];
    const lines = [...dataOf.get(chart.canvas).lines].sort((a, b) => a.x - b.x);
    inArea(chart, (ctx, area, pixel) => lines.forEach(({x, label}) => {
      ctx.strokeStyle = ctx.fillStyle = QUIET;
      ctx.setLineDash([3, 3]);
      ctx.beginPath();
      ctx.moveTo(pixel(x), area.top);
      ctx.lineTo(pixel(x), area.bottom);
      ctx.stroke();
      const width = ctx.measureText(label).width, from = Math.min(pixel(x) + 4, area.right - width - 4);
      const free = rowEnds.findIndex(end => end < from), row = free < 0 ? rowEnds.length : free;
      rowEnds[row] = from + width + 4;
      ctx.fillText(label, from, area.top + 12 + 13 * row);
    }));
  },
};

const zoomBox = {
  id: 'zoomBox',
  afterDraw(chart) {
    if (!chart.box) return;
    const {x0, y0, x1, y1} = chart.box;
    chart.ctx.save();
    chart.ctx.fillStyle = withAlpha('#0072B2', 0.12);
    chart.ctx.strokeStyle = '#0072B2';
    chart.ctx.fillRect(x0, y0, x1 - x0, y1 - y0);
    chart.ctx.strokeRect(x0, y0, x1 - x0, y1 - y0);
    chart.ctx.restore();
  },
};

// Whiskers from lower to upper, and the value beside each bar.
const errorBars = {
  id: 'errorBars',
  afterDatasetsDraw(chart) {
    const {ctx, scales, canvas} = chart, whole = fixed(dataOf.get(canvas).decimals);
    const pixel = value => scales.x.getPixelForValue(value);
    ctx.save();
    ctx.font = `12px ${Chart.defaults.font.family}`;
    ctx.textBaseline = 'middle';
    ctx.lineWidth = 1.5;
    chart.getSortedVisibleDatasetMetas().forEach(meta => meta.data.forEach((bar, i) => {
      const {values, lower, upper} = chart.data.datasets[meta.index].series;
      if (values[i] === null) return;
      const known = lower.length > 0 && lower[i] !== null && upper[i] !== null;
      ctx.strokeStyle = ctx.fillStyle = INK;
      if (known) whisker(ctx, pixel(lower[i]), pixel(upper[i]), bar.y, Math.min(6, bar.height / 3));
      ctx.fillText(whole(values[i]), Math.max(pixel(Math.max(values[i], 0)), known ? pixel(upper[i]) : 0) + 8, bar.y);
    }));
    ctx.restore();
  },
};

function whisker(ctx, from, to, y, half) {
  ctx.beginPath();
  for (const x of [from, to]) {
    ctx.moveTo(x, y - half);
    ctx.lineTo(x, y + half);
  }
  ctx.moveTo(from, y);
  ctx.lineTo(to, y);
  ctx.stroke();
}

// ---- zoom

const viewOf = ({scales: {x, y}}) => ({x: [x.min, x.max], y: [y.min, y.max]});

// What is seen at first: with equal scales the range of the data, else what the axes were given; undefined: their choice.
function homeOf(chart, data) {
  const {x, y} = chart.options.scales;
  return data.equal ? viewOf(chart) : {x: [x.min, x.max], y: [y.min, y.max]};
}

// The smallest view around `view` in which a unit is as long on both axes.
function equalised(view, area) {
  const unit = Math.max((view.x[1] - view.x[0]) / area.width, (view.y[1] - view.y[0]) / area.height);
  const around = ([low, high], length) => [(low + high - unit * length) / 2, (low + high + unit * length) / 2];
  return {x: around(view.x, area.width), y: around(view.y, area.height)};
}

function show(chart, view) {
  chart.wanted = view;
  const apply = ({x, y}) => {
    Object.assign(chart.options.scales.x, {min: x[0], max: x[1]});
    Object.assign(chart.options.scales.y, {min: y[0], max: y[1]});
    chart.update('none');
  };
  apply(view);
  // Twice, as the widths of the tick labels change the area.
  if (dataOf.get(chart.canvas).equal) for (let pass = 0; pass < 2; ++pass) apply(equalised(view, chart.chartArea));
}

function zoomAround(chart, at, factor) {
  const {x, y} = viewOf(chart), around = (c, [low, high]) => [c + (low - c) / factor, c + (high - c) / factor];
  show(chart, {x: around(at.x, x), y: around(at.y, y)});
}

function zoomCentre(chart, factor) {
  const {x, y} = viewOf(chart);
  zoomAround(chart, {x: (x[0] + x[1]) / 2, y: (y[0] + y[1]) / 2}, factor);
}

const valueAt = ({scales}, x, y) => ({x: scales.x.getValueForPixel(x), y: scales.y.getValueForPixel(y)});

function pan(chart, dx, dy) {
  const {scales} = chart, {x, y} = viewOf(chart);
  const sx = (x[1] - x[0]) / scales.x.width, sy = (y[1] - y[0]) / scales.y.height;
  show(chart, {x: x.map(v => v - dx * sx), y: y.map(v => v + dy * sy)});
}

function zoomToBox(chart) {
  const {x0, y0, x1, y1} = chart.box;
  chart.box = null;
  if (Math.abs(x1 - x0) < LEAST_BOX_PX || Math.abs(y1 - y0) < LEAST_BOX_PX) return chart.draw();
  const a = valueAt(chart, Math.min(x0, x1), Math.max(y0, y1)), b = valueAt(chart, Math.max(x0, x1), Math.min(y0, y1));
  show(chart, {x: [a.x, b.x], y: [a.y, b.y]});
}

// A drag with the mouse zooms to a box, with shift it moves the view; a double click shows all; ctrl + wheel and a
// touchpad's pinch zoom at the pointer. Touch is left to the page.
function listen(chart, home) {
  const {canvas} = chart;
  let last = null;
  const place = event => {
    const box = canvas.getBoundingClientRect();
    return {x: event.clientX - box.left, y: event.clientY - box.top};
  };
  const clamp = ({x, y}) => {
    const {left, right, top, bottom} = chart.chartArea;
    return {x: Math.min(right, Math.max(left, x)), y: Math.min(bottom, Math.max(top, y))};
  };
  canvas.addEventListener('pointerdown', event => {
    const {x, y} = place(event), at = clamp({x, y});
    if (event.pointerType !== 'mouse' || event.button !== 0 || at.x !== x || at.y !== y) return;
    canvas.setPointerCapture(event.pointerId);
    last = at;
    if (!event.shiftKey) chart.box = {x0: x, y0: y, x1: x, y1: y};
  });
  canvas.addEventListener('pointermove', event => {
    if (!last) return;
    const at = clamp(place(event));
    if (chart.box) {
      Object.assign(chart.box, {x1: at.x, y1: at.y});
      chart.draw();
    } else {
      pan(chart, at.x - last.x, at.y - last.y);
    }
    last = at;
  });
  const end = () => {
    last = null;
    if (chart.box) zoomToBox(chart);
  };
  canvas.addEventListener('pointerup', end);
  canvas.addEventListener('pointercancel', end);
  canvas.addEventListener('dblclick', () => show(chart, home));
  canvas.addEventListener('wheel', event => {
    if (!event.ctrlKey && !event.metaKey) return;
    event.preventDefault();
    const {x, y} = clamp(place(event));
    zoomAround(chart, valueAt(chart, x, y), event.deltaY < 0 ? WHEEL_STEP : 1 / WHEEL_STEP);
  }, {passive: false});
}

// ---- print

const PRINT_PX = {full: [680, 310], half: [330, 250]}, PRINT_PIXEL_RATIO = 4;

// On paper a chart is a picture drawn for the paper's width, as it is seen at the moment.
function drawForPrint(figure) {
  const chart = Chart.getChart(figure.querySelector('canvas')), image = new Image();
  const [width, height] = PRINT_PX[figure.classList.contains('half') ? 'half' : 'full'];
  const ratio = chart.options.devicePixelRatio;
  chart.options.devicePixelRatio = PRINT_PIXEL_RATIO;
  resize(chart, width, dataOf.get(chart.canvas).kind === 'bar' ? chart.height : height);
  image.className = 'printed';
  image.src = chart.toBase64Image();
  image.alt = chart.canvas.getAttribute('aria-label');
  chart.options.devicePixelRatio = ratio;
  const plot = figure.querySelector('.plot');
  plot.append(image);
  plot.classList.add('on-paper');
}

function resize(chart, ...size) {
  chart.resize(...size);
  if (chart.wanted) show(chart, chart.wanted);
}

addEventListener('beforeprint', () => document.querySelectorAll('figure.chart').forEach(drawForPrint));
addEventListener('afterprint', () => {
  document.querySelectorAll('.printed').forEach(image => image.remove());
  document.querySelectorAll('.on-paper').forEach(plot => plot.classList.remove('on-paper'));
  document.querySelectorAll('figure.chart canvas').forEach(canvas => resize(Chart.getChart(canvas)));
});

// ---- saving

function save(name, url) {
  const link = document.createElement('a');
  link.download = name;
  link.href = url;
  link.click();
}

const quoted = text => `"${String(text).replaceAll('"', '""')}"`;

function lineCsv(data) {
  const rows = data.series.flatMap(series => series.x.map((x, i) =>
    [quoted(series.name), x, series.y[i], series.lower[i], series.upper[i]].map(cell => cell ?? '').join(',')));
  return ['series,x,y,lower,upper', ...rows].join('\n') + '\n';
}

function barCsv(data) {
  const rows = data.series.flatMap(series => data.categories.map((category, i) =>
    [quoted(series.name), quoted(category), series.values[i], series.lower[i], series.upper[i]]
      .map(cell => cell ?? '').join(',')));
  return ['series,category,value,lower,upper', ...rows].join('\n') + '\n';
}

function addTools(figure, chart, data, home) {
  const name = (data.title || 'chart').replace(/[^\w-]+/g, '-').toLowerCase();
  const csv = () => 'data:text/csv;charset=utf-8,' + encodeURIComponent(data.kind === 'bar' ? barCsv(data) : lineCsv(data));
  const buttons = [
    ['PNG', 'Save as a picture', () => save(name + '.png', chart.toBase64Image())],
    ['CSV', 'Save the values', () => save(name + '.csv', csv())],
  ];
  if (home) {
    buttons.unshift(['+', 'Zoom in', () => zoomCentre(chart, BUTTON_STEP)],
                    ['\u2212', 'Zoom out', () => zoomCentre(chart, 1 / BUTTON_STEP)],
                    ['Reset', 'Show all (double click)', () => show(chart, home)]);
  }
  const tools = document.createElement('div');
  tools.className = 'tools';
  if (home) tools.innerHTML = '<span class="hint">drag: zoom \u00b7 shift + drag: move \u00b7 double click: all</span>';
  for (const [text, title, action] of buttons) {
    const button = document.createElement('button');
    Object.assign(button, {type: 'button', textContent: text, title, onclick: action});
    button.setAttribute('aria-label', title);
    tools.append(button);
  }
  figure.querySelector('.plot').after(tools);
}

// ----

function draw(figure) {
  const data = JSON.parse(figure.querySelector('script[type="application/json"]').textContent);
  const canvas = figure.querySelector('canvas');
  dataOf.set(canvas, data);
  if (data.kind === 'bar') figure.querySelector('.plot').style.height = barHeight(data);
  const chart = new Chart(canvas, data.kind === 'bar' ? barConfig(data) : lineConfig(data));
  if (data.kind === 'bar') return addTools(figure, chart, data, null);
  const home = homeOf(chart, data);
  show(chart, home);
  listen(chart, home);
  addTools(figure, chart, data, home);
}

document.documentElement.classList.add('drawn');  // the places of the charts have their size from here on
Chart.defaults.font.family = getComputedStyle(document.body).fontFamily;
Chart.defaults.font.size = 12;
document.querySelectorAll('figure.chart').forEach(draw);
})();
