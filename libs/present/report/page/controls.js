// What a reader does with the charts: zoom, print, save. Comes behind charts.js, in the same function.
const WHEEL_STEP = 1.2, BUTTON_STEP = 1.5, LEAST_BOX_PX = 8;

// ---- zoom

const viewOf = ({scales: {x, y}}) => ({x: [x.min, x.max], y: [y.min, y.max]});

// What is seen at first: with equal scales the range of the data, else what the axes were given; undefined is their
// own choice.
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

const placeOf = (chart, event) => {
  const box = chart.canvas.getBoundingClientRect();
  return {x: event.clientX - box.left, y: event.clientY - box.top};
};

const clamped = ({chartArea: {left, right, top, bottom}}, {x, y}) =>
  ({x: Math.min(right, Math.max(left, x)), y: Math.min(bottom, Math.max(top, y))});

// A drag with the mouse zooms to a box, with shift it moves the view. Touch is left to the page.
function listenToDrags(chart) {
  const {canvas} = chart;
  let last = null;
  canvas.addEventListener('pointerdown', event => {
    const {x, y} = placeOf(chart, event), at = clamped(chart, {x, y});
    if (event.pointerType !== 'mouse' || event.button !== 0 || at.x !== x || at.y !== y) return;
    canvas.setPointerCapture(event.pointerId);
    last = at;
    if (!event.shiftKey) chart.box = {x0: x, y0: y, x1: x, y1: y};
  });
  canvas.addEventListener('pointermove', event => {
    if (!last) return;
    const at = clamped(chart, placeOf(chart, event));
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
}

// A double click shows all; ctrl + wheel and a touchpad's pinch zoom at the pointer.
function listen(chart, home) {
  listenToDrags(chart);
  chart.canvas.addEventListener('dblclick', () => show(chart, home));
  chart.canvas.addEventListener('wheel', event => {
    if (!event.ctrlKey && !event.metaKey) return;
    event.preventDefault();
    const {x, y} = clamped(chart, placeOf(chart, event));
    zoomAround(chart, valueAt(chart, x, y), event.deltaY < 0 ? WHEEL_STEP : 1 / WHEEL_STEP);
  }, {passive: false});
}

// ---- print

const PRINT_PX = {full: [680, 310], half: [330, 250]}, PRINT_PIXEL_RATIO = 4;

// A picture for paper or another page: dark ink on white, whatever the screen has.
function pictureOf(chart) {
  const before = theme;
  theme = LIGHT;
  chart.update('none');
  const picture = chart.toBase64Image();
  theme = before;
  chart.update('none');
  return picture;
}

// On paper a chart is a picture drawn for the paper's width, as it is seen at the moment.
function drawForPrint(figure) {
  const chart = Chart.getChart(figure.querySelector('canvas')), image = new Image();
  const [width, height] = PRINT_PX[figure.classList.contains('half') ? 'half' : 'full'];
  const ratio = chart.options.devicePixelRatio;
  chart.options.devicePixelRatio = PRINT_PIXEL_RATIO;
  resize(chart, width, dataOf.get(chart.canvas).kind === 'bar' ? chart.height : height);
  image.className = 'printed';
  image.src = pictureOf(chart);
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
  const table = () => data.kind === 'bar' ? barCsv(data) : lineCsv(data);
  const csv = () => 'data:text/csv;charset=utf-8,' + encodeURIComponent(table());
  const buttons = [
    ['PNG', 'Save as a picture', () => save(name + '.png', pictureOf(chart))],
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
darkness.addEventListener('change', () => {
  theme = darkness.matches ? DARK : LIGHT;
  document.querySelectorAll('figure.chart canvas').forEach(canvas => Chart.getChart(canvas).update('none'));
});
