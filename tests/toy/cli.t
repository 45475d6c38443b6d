#!/usr/bin/perl
# A method and three processes that only the tables of config=toy know, on the command line.
use strict;
use warnings;
use FindBin;
use lib $FindBin::Bin, "$FindBin::Bin/../cli";
use Toy;
use Cli;
use JSON::PP;
use Test::More;

my $folder = scratch();
my $in = spew("$folder/in.ply", sphere(1500));
my $out = "$folder/out.ply";
my $plane = spew("$folder/plane.ply", cloud_of(grid(5, 0, 0, 0)));
my $moved = spew("$folder/moved.ply", cloud_of(grid(5, 0.125, 0, 0.25)));

sub near { return cmp_ok abs($_[0] - $_[1]), '<=', 1e-6 * abs($_[1]) + 1e-9, $_[2] }

# The document that a run prints.
sub document {
    my ($name, @arguments) = @_;
    my ($code, $stdout, $stderr) = run(\@arguments);
    is "$code$stderr", '0', "$name: all is well";
    return decode_json($stdout || '{}');
}

sub refused {
    my ($name, $arguments, $code, $line) = @_;
    my ($got, $stdout, $stderr) = run($arguments);
    is "$got|$stdout|$stderr", "$code||voronoid: $line\n", $name;
}

subtest 'help comes of the tables' => sub {
    my (undef, $overview) = run(['--help']);
    like $overview, qr/^  excerpt +Take an excerpt of a point cloud$/m, 'the overview has the first process';
    like $overview, qr/^  \Q$_\E +\S/m, "and $_" for qw(resample measure census overlap);
    my (undef, $census) = run(['census', '--help']);
    is_deeply [$census =~ /^      --(\w+)(?: VALUE|\[=VALUE\])$/mg],
        [qw(parts pause among axes nearby strict remark tell)], 'the help of a process shows its parameters only';
    like $census, qr/^      --\Q$_->[0]\E\n[^\n]+\n      \Q$_->[1]\E$/m, "$_->[0]: $_->[1]" for (
        ['parts VALUE', '1 to 100000 steps, default 4'], ['pause VALUE', '0 to 60 s | none | blink, default none'],
        ['among VALUE', 'all | attribute:NAME, default all'],
        ['axes VALUE', 'some of x,y,z | none | auto, default auto'],
        ['nearby VALUE', '0 to 1e+30 unit of the cloud | auto, default auto'],
        ['strict[=VALUE]', 'true | false, default false'], ['remark VALUE', 'text of 0 to 60 bytes'],
        ['tell VALUE', 'some of box,middle | none, default box,middle'],
    );
    like $census, qr/^      --server URL$/m, 'a daemon may take the census';
    my (undef, $overlap) = run(['overlap', '--help']);
    like $overlap, qr/^      --other FILE\n      The cloud beside it \(required\)$/m, 'an input that is an option, and required';
    like $overlap, qr/^The overlap:\n      --backward\[=VALUE\]$/m, 'a group of its own';
    like $overlap, qr/--parts VALUE\n[^\n]+\n      1 to 100000 steps, default 3$/m, 'a preset shows as its default';
    unlike $overlap, qr/--(?:tell|server|points)\b/, 'and nothing that it does not take';
    my (undef, $resample) = run(['resample', '--help']);
    like $resample, qr/--method VALUE\n[^\n]+\n      cvt \| kmeans \| wlop \| ear \| toy, default cvt$/m, 'resample has the method';
    like $resample, qr/^The steps of the toy:\n      --parts VALUE$/m, 'and its parameters';
    my (undef, $excerpt) = run(['excerpt', '--help']);
    like $excerpt, qr/--method VALUE\n[^\n]+\n      toy, default toy$/m, 'excerpt has no other';
    unlike $excerpt, qr/--polish\b/, 'nor its parameters';
    my (undef, $manual) = run(['--man', 1]);
    like $manual, qr/^\.TP\n\\fBexcerpt\\fR$/m, 'the manual has a process that no file of the product knows';
    like $manual, qr/^\.TP\n\\fB\\-\\-parts\\fR \\fIVALUE\\fR$/m, 'and its parameters';
    for my $shell (qw(bash zsh)) {
        my (undef, $completion) = run(['--completion', $shell]);
        like $completion, qr/\boverlap\b.*--other\b/s, "so has the completion for $shell";
    }
};

subtest 'the method copies points of the input' => sub {
    my ($code, $stdout, $stderr) = run(['resample', $in, '-n', 300, '--method', 'toy', '--parts', 5, '--json', '-o', $out]);
    is "$code$stderr", '0', 'all is well';
    my @records = lines($stdout);
    my $report = pop @records;
    my $last = pop @records;
    is "$last->{run_stage} $last->{step}", 'prove 5', 'the last record is of the result';
    is $last->{best}{$_}, $report->{$_}, "its best has the $_ of the report" for qw(delta sigma epsilon);
    is_deeply [map { [@$_{qw(run_stage step of ahead)}] } @records],
        [(map { ['copy', $_, 5, 5] } 0 .. 5), (map { ['prove', $_, 5, 0] } 0 .. 5)], 'records tell its stages';
    is scalar(grep { defined $_->{delta} || defined $_->{energy} || defined $_->{best}{delta} } @records), 0, 'and not what it does not know';
    my @copies = positions(slurp($out));
    is scalar(@copies), 300, 'as many as asked for';
    cmp_ok far_from(\@copies, [positions(slurp($in))]), '<', 1e-6, 'each is a point of the input';
    is scalar(keys %{ { map { ("@$_" => 1) } @copies } }), 300, 'none comes twice';
    is_deeply $report->{points}, { in => 1500, out => 300 }, 'the report counts them';
    is $report->{stopped}, 'copied', 'it says why the run ended';
    is_deeply [map { [@$_{qw(stage steps)}] } @{ $report->{stages} }], [['copy', 5], ['prove', 5]], 'which stages it had';
    is_deeply [@{ $report->{parameters} }{qw(method points parts pause)}], ['toy', 300, 5, 'none'], 'and what was asked';
    is $report->{out_to_in}{max}, 0, 'that no point left the input';
    cmp_ok $report->{delta}, '>', 0.1, 'and how uneven they are';
    my $bytes = slurp($out);
    for my $threads (1, 3, 8) {
        run(['excerpt', $in, '-n', 300, "--threads=$threads", '-q', '-o', $out]);
        ok slurp($out) eq $bytes, "excerpt by $threads threads gives the same bytes";
    }
};

subtest 'what the method does not do' => sub {
    refused 'more points than the input has', ['upsample', $in, '--method', 'toy', '-o', $out], 3,
        "$in: 6000 points are asked for, want 1 to 1500: toy copies points of the input, and only those at different places";
    refused 'another method', ['excerpt', $in, '-n', 5, '--method', 'cvt', '-o', $out], 2,
        'excerpt: method is "cvt", want one of toy';
    refused 'no such method', ['resample', $in, '-n', 5, '--method', 'lop', '-o', $out], 2,
        'resample: method is "lop", want one of cvt, kmeans, wlop, ear, toy';
    my ($code, undef, $stderr) = run(['resample', $in, '-n', 300, '--iterations', 2, '--polish', 0, '-o', $out]);
    like $stderr, qr/after 2 iterations \(iterations\)/, 'cvt is the default, and goes through its own stages';
};

subtest 'what is shown of its stages' => sub {
    my ($code, undef, $stderr) = run(['resample', $in, '-n', 300, '--method=toy', '--pause=blink', '-o', $out]);
    like $stderr, qr/\Avoronoid: \Q$out\E: 300 points, delta \d\.\d{4} after 4 copied parts and 4 proved parts \(copied\), (\d+\.\d) s\n\z/,
        'the summary names them';
    my ($seconds) = $stderr =~ /(\d+\.\d) s$/;
    cmp_ok $seconds, '>=', 0.4, 'and has their time: eight steps of 0.05 s';
    plan skip_all => 'script(1) makes no terminal here'
        if system('script -qec true /dev/null >/dev/null 2>&1 </dev/null') != 0;
    my $command = "stty cols 80; build/toy/voronoid resample $in -n 300 --method toy --parts 5 --pause 0.15 -o $out";
    my $text = `script -qec "$command" /dev/null </dev/null`;
    my @drawn = $text =~ /\r\e\[K((?:copy|prove) +\d[^\r]*)/g;
    like $drawn[0], qr{^copy    0/5    \[-+\]   0 %\z}, 'the bar begins empty';
    is_deeply [grep { !m{^(?:copy|prove)    \d/5    \[#*-*\] +\d+ %(?:  \d+ s left)?\z} } @drawn], [],
        'it shows stage, step and limit, and no delta';
    my @percent = map {/ (\d+) %/} @drawn;
    is_deeply [@percent], [sort { $a <=> $b } @percent], 'its share rises over both stages';
    ok((grep {/^copy.* 50 %/} @drawn) && (grep {/^prove.*100 %/} @drawn), 'half is done after the first, all after the second');
    my @left = map {/ (\d+) s left/} @drawn;
    ok $left[0] > 0 && $left[-1] == 0, 'the time left comes to nothing';
};

subtest 'an interrupt ends it in the middle' => sub {
    unlink $out;
    my $log = spew("$folder/records", '');
    my $process = start(['resample', $in, '-n', 300, '--method', 'toy', '--pause', 20, '--json', '-o', $out], stdout => $log);
    ok await { slurp($log) =~ /"run_stage":"copy"/ }, 'the first stage begins';
    kill 'INT', $process->{pid};
    my ($code, undef, $stderr) = finish($process, 10);
    is "$code|$stderr", "130|voronoid: $in: cancelled\n", 'it does not wait for the step';
    ok !-e $out, 'and leaves nothing';
};

subtest 'a census' => sub {
    my $got = document('census', 'census', $plane, '--nearby', 0.25);
    is_deeply $got, { points => 25, seen => 25, counted => 25, near => 5, nearby => 0.25, box => { x => 1, y => 1, z => 0 },
            middle => { x => 0.5, y => 0.5, z => 0 },
            parameters => { parts => 4, pause => 'none', among => 'all', axes => 'auto', nearby => 0.25,
                strict => JSON::PP::false, tell => ['box', 'middle'] } }, 'it counts and measures';
    is document('strict', 'census', $plane, '--nearby', 0.25, '--strict')->{near}, 1, 'strict leaves out those just there';
    near document('auto', 'census', $plane)->{nearby}, sqrt(2) / 2, 'near is half the diagonal';
    is document('attribute', 'census', $plane, '--among', 'attribute:flag')->{counted}, 5, 'by an attribute';
    is document('axes', 'census', $plane, '--axes', 'x', '--nearby', 0)->{near}, 5, 'along an axis';
    is_deeply [map { exists document('tell', 'census', $plane, '--tell', 'middle')->{$_} ? 1 : 0 } qw(box middle)], [0, 1],
        'parts that are not asked for are left out';
    is_deeply [map { exists document('none', 'census', $plane, '--tell=none')->{$_} ? 1 : 0 } qw(box middle)], [0, 0], 'nor any';
    my ($code, $stdout) = run(['census', $plane, '--json', '-o', "$folder/census.json"]);
    is_deeply [map { "$_->{run_stage} $_->{step}/$_->{of}+$_->{ahead}" } lines($stdout)],
        [(map {"tally $_/4+4"} 0 .. 4), (map {"reach $_/4+0"} 0 .. 4)], 'its stages are told';
    cmp_ok((lines($stdout))[-1]{seconds}, '<', 60, 'from its own beginning');
    is decode_json(slurp("$folder/census.json"))->{points}, 25, 'the document goes where it is sent';
    refused 'an attribute that is not there', ['census', $plane, '--among', 'attribute:no'], 2,
        "$plane: among is attribute:no, want all or an attribute that the cloud has";
};

subtest 'two clouds in, a document out' => sub {
    my $got = document('overlap', 'overlap', $plane, '--other', $moved);
    my $apart = sqrt(0.125**2 + 0.25**2);
    is_deeply $got->{points}, { cloud => 25, other => 25, counted => 25 }, 'points of both';
    near $got->{forth}{$_}, $apart, "$_ distance" for qw(mean max);
    ok !exists $got->{back}, 'the way back only on request';
    is $got->{parameters}{parts}, 3, 'the preset holds';
    $got = document('all', 'overlap', $moved, '--other', $plane, '--backward', '--axes=x,y', '--among=attribute:flag',
        '--nearby', 0.125);
    is $got->{points}{counted}, 5, 'those with the flag';
    near $got->{forth}{max}, 0.125, 'flat along z';
    near $got->{back}{max}, 0.125, 'and back';
    is $got->{near}, 5, 'all near';
    my ($code, $stdout) = run(['overlap', $plane, '--other', $moved, '--backward', '--json', '-o', "$folder/overlap.json"]);
    is_deeply [map { "$_->{run_stage} $_->{step}/$_->{of}+$_->{ahead}" } lines($stdout)],
        [(map {"forth $_/3+3"} 0 .. 3), (map {"back $_/3+0"} 0 .. 3)], 'its stages are told';
    ($code, $stdout) = run(['overlap', '-', '--other', $moved], stdin => $plane);
    is $code, 0, 'one of them may be stdin';
    refused 'one cloud', ['overlap', $plane], 2, 'overlap: overlap has no other, and needs one: give --other FILE too';
    refused 'two stdins', ['overlap', '-', '--other', '-'], 2, 'overlap: both clouds are -, and there is only one stdin';
    refused 'an input of another process', ['census', $plane, '--other', $moved], 2,
        'census: no option --other; see voronoid census --help';
    refused 'a file that is not there', ['overlap', $plane, '--other', "$folder/no.ply"], 1,
        "$folder/no.ply: cannot be read: No such file or directory";
};

# What is written, what the document says of it.
subtest 'every kind is taken and told' => sub {
    for my $case (
        ['strict', [], JSON::PP::true], ['strict', 'true', JSON::PP::true], ['strict', 'false', JSON::PP::false],
        ['remark', '', ''], ['remark', "\xc3\xa9 \"q\" \\, =&%", "\x{e9} \"q\" \\, =&%"], ['remark', 'x' x 60, 'x' x 60],
        ['tell', 'middle,box', ['box', 'middle']], ['tell', 'box', ['box']], ['tell', 'none', []],
        ['among', 'all', 'all'], ['among', 'attribute:flag', 'attribute:flag'],
        ['pause', 'blink', 'blink'], ['pause', '0', 0], ['pause', '1e-3', 0.001], ['pause', 'none', 'none'],
        ['axes', 'auto', 'auto'], ['axes', 'z,x', ['x', 'z']], ['axes', 'none', []],
        ['nearby', 'auto', 'auto'], ['nearby', '2.5', 2.5], ['parts', '7', 7],
    ) {
        my ($name, $text, $wanted) = @$case;
        my $got = document("$name", 'census', $plane, ref $text ? "--$name" : "--$name=$text")->{parameters};
        is_deeply $got->{$name}, $wanted, "$name " . (ref $text ? 'alone' : "'$text'") . ' is told as it was meant';
    }
};

# A request that was told is the same when it is asked again.
subtest 'a request goes round' => sub {
    my $first = document('once', 'census', $plane, '--strict', '--remark', "\xc3\xa9, and more", '--tell', 'middle', '--among',
        'attribute:flag', '--pause', 'blink', '--axes', 'x,y', '--nearby', 0.1, '--parts', 2);
    my @again = map {
        my $value = $first->{parameters}{$_};
        my $text = ref $value eq 'ARRAY' ? join ',', @$value : JSON::PP::is_bool($value) ? ($value ? 'true' : 'false') : $value;
        utf8::encode($text);
        "--$_=$text";
    } sort keys %{ $first->{parameters} };
    is_deeply document('again', 'census', $plane, @again), $first, 'the same document';
    is scalar(@again), 8, 'of eight parameters';
};

subtest 'every kind refuses what it is not' => sub {
    my ($long, $longer) = ('x' x 61, 'x' x 600);
    for my $case (
        ['strict', '=maybe', 'strict is "maybe", want true or false'], ['strict', '=1', 'strict is "1", want true or false'],
        ['remark', "=$long", qq(remark is "$long", want text of 0 to 60 bytes)],
        ['remark', "=$longer", qr/remark is "x{40,}\.\.\.", want text of 0 to 60 bytes/],
        ['remark', "=a\x01", qr/remark is "a\S+", want text of 0 to 60 bytes/],
        ['tell', '=box,box', 'tell is "box,box", want each at most once and with commas between, words of box, middle, or none'],
        ['tell', '=side', 'tell is "side", want each at most once and with commas between, words of box, middle, or none'],
        ['tell', '=', 'tell is empty, want each at most once and with commas between, words of box, middle, or none'],
        ['tell', '=auto', 'tell is "auto", want each at most once and with commas between, words of box, middle, or none'],
        ['among', '=some', 'among is "some", want one of all or attribute:NAME of 1 to 40 bytes'],
        ['among', '=attribute:', 'among is "attribute:", want one of all or attribute:NAME of 1 to 40 bytes'],
        ['among', '=attribute', 'among is "attribute", want one of all or attribute:NAME of 1 to 40 bytes'],
        ['pause', '=61', 'pause is 61, want a number from 0 to 60 or one of none, blink'],
        ['pause', '=-1', 'pause is -1, want a number from 0 to 60 or one of none, blink'],
        ['pause', '=auto', 'pause is auto, want a number from 0 to 60 or one of none, blink'],
        ['axes', '=x,w', 'axes is "x,w", want each at most once and with commas between, words of x, y, z, or none or auto'],
        ['axes', '=auto,x', 'axes is "auto,x", want each at most once and with commas between, words of x, y, z, or none or auto'],
        ['nearby', '=inf', 'nearby is inf, want a number from 0 to 1e+30 or auto'],
        ['nearby', '=-0.5', 'nearby is -0.5, want a number from 0 to 1e+30 or auto'],
        ['parts', '=0', 'parts is 0, want a whole number from 1 to 100000'],
        ['parts', '=1.5', 'parts is 1.5, want a whole number from 1 to 100000'],
    ) {
        my ($name, $text, $line) = @$case;
        my ($code, $stdout, $stderr) = run(['census', $plane, "--$name$text"]);
        my $wanted = ref $line ? $line : qr/\Q$line\E/;
        is "$code|$stdout", '2|', "--$name$text: a usage error";
        like $stderr, qr/\Avoronoid: census: $wanted\n\z/, "--$name$text: names value and range";
    }
};

subtest 'what a process does not take is refused by name' => sub {
    my $takes = 'parts, pause, among, axes, nearby, strict, remark';
    refused 'a parameter of resample', ['census', $plane, '--points', 5], 2,
        "census: no parameter points; census takes $takes, tell";
    refused 'a parameter of another toy', ['census', $plane, '--backward'], 2,
        "census: no parameter backward; census takes $takes, tell";
    refused 'the other way', ['overlap', $plane, '--other', $moved, '--tell', 'box'], 2,
        "overlap: no parameter tell; overlap takes $takes, backward";
    refused 'a toy of a product', ['measure', $plane, '--strict'], 2, 'measure: no parameter strict; measure takes invalid, peak';
    my ($code, $stdout, $stderr) = run(['resample', $in, '-n', 5, '--remark', 'x', '-o', $out]);
    like "$code|$stdout|$stderr", qr/\A2\|\|voronoid: resample: no parameter remark; resample takes points, .*, normals, baselines, parts, pause\n\z/,
        'and of the processes that spread points';
    ($code, $stdout, $stderr) = run(['excerpt', $in, '-n', 5, '--polish', 5, '-o', $out]);
    like "$code|$stdout|$stderr", qr/\A2\|\|voronoid: excerpt: no parameter polish; excerpt takes points, /,
        'a group that a process leaves out';
    refused 'a letter', ['census', $plane, '-n', 5], 2, 'census: no option -n; see voronoid census --help';
};

is leftovers($folder, qw(in.ply out.ply plane.ply moved.ply records census.json overlap.json)), '', 'nothing is left behind';
done_testing;
