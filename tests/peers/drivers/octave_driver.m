% Evaluates .fis files with Octave's fuzzy-logic-toolkit. Argument: a folder. Reads every NAME.fis in it with its points
% NAME.points, one a line, and writes the outputs to NAME.out, or to NAME.err why there are none. A point for which the
% toolkit stops with an error has the word "error" in each place of its line.
pkg load fuzzy-logic-toolkit
folder = argv (){end};
files = dir (fullfile (folder, "*.fis"));
for k = 1 : numel (files)
  path = fullfile (folder, files(k).name);
  base = path(1 : end - 4);
  try
    fis = readfis (path);
    points = load ([base ".points"]);
    out = "";
    for row = 1 : rows (points)
      try
        out = [out sprintf("%.17g ", evalfis (points(row, :), fis)) "\n"];
      catch reason
        if (isempty (strfind (reason.message, "out of bound")))
          rethrow (reason);
        endif
        out = [out repmat("error ", 1, columns (fis.output)) "\n"];
      end_try_catch
    endfor
    file = fopen ([base ".out"], "w");
    fputs (file, out);
    fclose (file);
  catch reason
    file = fopen ([base ".err"], "w");
    fputs (file, [reason.message "\n"]);
    fclose (file);
  end_try_catch
endfor
