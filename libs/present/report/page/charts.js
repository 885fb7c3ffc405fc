// Draws the charts of a report with Chart.js: each <figure class="chart"> holds a canvas and its data as JSON.
const LIGHT = {ink: '#222222', quiet: '#5f5f5f', grid: '#ececec', shade: '#f1f1f1', paper: '#ffffff'};
const DARK = {ink: '#e6e6e6', quiet: '#a6a6a6', grid: '#333437', shade: '#2a2b2e', paper: '#1a1b1d'};
const darkness = matchMedia('(prefers-color-scheme: dark)');
let theme = darkness.matches ? DARK : LIGHT;
const ink = () => theme.ink, quiet = () => theme.quiet, grid = () => theme.grid;
const LEAST_CONTRAST = 3;  // of a line (WCAG 2.1)
const channels = colour => [1, 3, 5].map(at => parseInt(colour.slice(at, at + 2), 16) / 255);
const luminance = colour => channels(colour).map(c => c <= 0.04045 ? c / 12.92 : ((c + 0.055) / 1.055) ** 2.4)
  .reduce((sum, c, i) => sum + [0.2126, 0.7152, 0.0722][i] * c, 0) + 0.05;
const contrast = (a, b) => Math.max(luminance(a) / luminance(b), luminance(b) / luminance(a));
const towards = (colour, other, part) => '#' + channels(colour).map((c, i) => c + part * (channels(other)[i] - c))
  .map(c => Math.round(255 * c).toString(16).padStart(2, '0')).join('');

// Ink of the data is that of the page; what would hardly be seen on its ground comes nearer to the ink.
function shown(colour) {
  return () => {
    if (colour === LIGHT.ink) return theme.ink;
    let part = 0;
    while (part < 1 && contrast(towards(colour, theme.ink, part), theme.paper) < LEAST_CONTRAST) part += 0.1;
    return towards(colour, theme.ink, part);
  };
}
const DASHES = {line: [], thin: [], dashed: [8, 5], dotted: [2, 4], points: []};
const WIDTHS = {line: 2.25, thin: 1, dashed: 2.25, dotted: 2.25, points: 1};
const dataOf = new WeakMap();  // of each chart's canvas
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
    label: series.name, data: series.x.map((x, i) => ({x, y: series.y[i]})), series,
    order: points ? 0 : DASHES[series.mark].length ? 0.5 : 1,  // between its dashes what lies below is seen
    borderColor: shown(series.colour), backgroundColor: shown(series.colour), borderDash: DASHES[series.mark],
    showLine: !points, borderWidth: WIDTHS[series.mark], pointHoverRadius: 5,
    pointRadius: !points ? 0 : series.x.length > MANY ? 2 : 4,
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
    type: 'linear', reverse: axis.downwards, min: axis.from ?? undefined, max: axis.to ?? undefined,
    title: {display: axis.label !== '', text: axis.label, color: ink},
    grid: {color: grid, borderColor: quiet, tickColor: quiet, tickLength: 5},
    ticks: {
      color: ink, includeBounds: false, maxRotation: 0, callback: value => minus(String(Number(value.toPrecision(9)))),
    },
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
      ...common(), indexAxis: 'y', layout: {padding: {right: VALUE_PX}},
      interaction: {mode: 'nearest', axis: 'y', intersect: false},
      scales: {x: axisOf(data.x, reach), y: {grid: {display: false, borderColor: quiet}, ticks: {color: ink}}},
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
    color: ink, usePointStyle: true, pointStyleWidth: 26, boxHeight: 6,
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
    ctx.fillStyle = theme.paper;
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
      ctx.fillStyle = theme.shade;
      ctx.fillRect(pixel(from), area.top, pixel(to) - pixel(from), area.height);
      ctx.fillStyle = theme.quiet;
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
      ctx.strokeStyle = ctx.fillStyle = theme.quiet;
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
      ctx.strokeStyle = ctx.fillStyle = theme.ink;
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
