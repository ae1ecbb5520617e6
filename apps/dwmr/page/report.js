// The report: each plot at its place, and its buttons.
facts.plots.forEach((data, k) => document.getElementById(`plot-${k}`).append(new PanelPlot(data).box));
document.body.dataset.ready = "yes";
