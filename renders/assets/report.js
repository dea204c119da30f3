// Draws every <figure class="plot"> of a report with uPlot, in the page's colours, again
// when the window's width or the light/dark scheme changes.
(function () {
  'use strict';

  function colour(name) {
    return getComputedStyle(document.documentElement).getPropertyValue(name).trim();
  }

  // One table of x and y a series, joined over all x; places without a value are null.
  function joined(series) {
    return uPlot.join(series.map(function (s) { return [s.x, s.y]; }));
  }

  function options(plot, width) {
    var dim = colour('--dim'), line = colour('--line');
    var axis = {
      stroke: dim, grid: {stroke: line, width: 1}, ticks: {stroke: line, width: 1},
      font: '12px system-ui, sans-serif', labelFont: '12px system-ui, sans-serif', labelSize: 20
    };
    var num_points = plot.series.reduce(function (n, s) { return n + s.x.length; }, 0);
    var size = num_points > 400 ? 3 : 5;
    var series = plot.series.map(function (s, i) {
      var stroke = colour('--series-' + (i % 6 + 1));
      return {
        label: s.label, stroke: stroke, spanGaps: true, width: s.line ? 1.6 : 0,
        paths: s.line ? undefined : function () { return null; },
        points: {show: true, size: size, fill: stroke, stroke: stroke}
      };
    });
    return {
      width: width, height: 260,
      scales: {x: {time: false}},
      axes: [Object.assign({label: plot.x, size: 34, incrs: [1, 2, 5, 10, 20, 50, 100, 200, 500, 1000, 2000, 5000]}, axis), Object.assign({label: plot.y, size: 58}, axis)],
      series: [{label: plot.x}].concat(series),
      legend: {live: false, markers: {fill: function (u, i) { return u.series[i].stroke(u, i); }}},
      cursor: {points: {show: false}}
    };
  }

  var figures = Array.prototype.map.call(document.querySelectorAll('figure.plot'), function (figure) {
    return {
      place: figure.querySelector('.canvas'),
      plot: JSON.parse(figure.querySelector('script').textContent),
      drawn: null
    };
  });

  function draw(figure) {
    if (figure.drawn) figure.drawn.destroy();
    figure.drawn = new uPlot(options(figure.plot, figure.place.clientWidth), joined(figure.plot.series), figure.place);
  }

  function drawAll() { figures.forEach(draw); }

  drawAll();
  var waiting = null, width = window.innerWidth;
  window.addEventListener('resize', function () {
    if (window.innerWidth === width) return;
    width = window.innerWidth;
    clearTimeout(waiting);
    waiting = setTimeout(drawAll, 150);
  });
  window.matchMedia('(prefers-color-scheme: dark)').addEventListener('change', drawAll);
})();
