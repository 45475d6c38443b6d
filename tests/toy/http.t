#!/usr/bin/perl
# A method and processes that only the tables of config=toy know, over HTTP: described, run, followed, stopped, cancelled,
# and taken up again by the next daemon.
use strict;
use warnings;
use Digest::SHA qw(sha256_hex);
use FindBin;
use lib $FindBin::Bin, "$FindBin::Bin/../cli", "$FindBin::Bin/../support";
use Toy;
use Cli ();
use JSON::PP;
use Test::More;
use Vt;

my $daemon = Vt->start(jobs => 2, heartbeat => 1);
my $plane = cloud_of(grid(5, 0, 0, 0));
my $sphere = Cli::sphere(1500);
my $stream_of = { Accept => 'text/event-stream' };

# What is said as a query: every kind, none at its default.
my %said = (
    parts => 3, pause => 'blink', among => 'attribute:flag', axes => 'x,y', nearby => '0.25', strict => 'true',
    remark => '%C3%A9%20%26%20%22q%22', tell => 'middle',
);
my $said = join '&', map {"$_=$said{$_}"} sort keys %said;
my %told = (
    parts => 3, pause => 'blink', among => 'attribute:flag', axes => ['x', 'y'], nearby => 0.25, strict => JSON::PP::true,
    remark => "\x{e9} & \"q\"", tell => ['middle'],
);
my $counted = { points => 25, seen => 25, counted => 5, near => 1, nearby => 0.25, middle => { x => 0, y => 0.5, z => 0 },
    parameters => \%told };

sub submit {
    my ($path, $body) = @_;
    my $answer = $daemon->post("/v1/$path", $body, Prefer => 'respond-async');
    is $answer->{status}, 201, "POST $path is accepted" or diag($answer->{content});
    return json($answer)->{jobID};
}

sub progress { return map { json($_->{data}) } grep { $_->{event} eq 'progress' } @_ }
sub never_falls { return !grep { $_[$_] < $_[$_ - 1] } 1 .. $#_ }
sub stages { return map {"$_->{run_stage} $_->{step}/$_->{of}+$_->{ahead}"} @_ }

# Every event of a job from its first record on.
sub every_event { return $daemon->events("/v1/jobs/$_[0]/events", headers => { 'Last-Event-ID' => "$_[1].1" })->all }

# The estimates of a run of two stages, of as many steps each: by the pace of the stage at hand, at its beginning by that
# of the one before. How long steps take on a busy machine does not matter to that.
sub estimates_follow {
    my ($start, @records) = @_;
    my ($before, $pace) = ($start);
    is $start->{eta}, undef, 'there is no estimate before the first step';
    my @wrong = grep {
        my $record = $_;
        $before = $record if $record->{step} == 0;
        $pace = ($record->{seconds} - $before->{seconds}) / $record->{step} if $record->{step} > 0;
        my $left = $pace * ($record->{of} - $record->{step} + $record->{ahead});
        abs(($record->{eta} // -1) - $left) > 1e-6;
    } @records;
    is_deeply [stages(@wrong)], [], 'then it follows the pace of each stage';
    cmp_ok $records[0]{eta}, '>', $records[-2]{eta}, 'falls over both';
    is $records[-1]{eta}, 0, 'and ends with nothing left';
}

# Waits until a running job has told so many steps of a stage.
sub reaches {
    my ($id, $stage, $step) = @_;
    return wait_until(
        sub {
            my $record = json($daemon->get("/v1/jobs/$id"))->{voronoid}{metrics} // {};
            ($record->{run_stage} // '') eq $stage && $record->{step} >= $step;
        }, 30);
}

subtest 'descriptions come of the tables' => sub {
    my @ids = map { $_->{id} } @{ json($daemon->get('/v1/processes'))->{processes} };
    is_deeply \@ids, [qw(resample denoise upsample simplify measure inspect convert mesh excerpt census ribbon poison)], 'the list has those that HTTP offers';
    my $census = json($daemon->get('/v1/processes/census'));
    is_deeply [sort keys %{ $census->{inputs} }], [sort 'cloud', keys %told], 'the inputs of one';
    my %schema = map { $_ => $census->{inputs}{$_}{schema} } keys %{ $census->{inputs} };
    my $list = sub { { type => 'array', uniqueItems => JSON::PP::true, items => { type => 'string', enum => [@_] } } };
    my $word = sub { { type => 'string', enum => [@_] } };
    is_deeply $schema{$_->[0]}, $_->[1], "the schema of $_->[0]" for (
        ['strict', { type => 'boolean', default => JSON::PP::false }],
        ['remark', { type => 'string', minLength => 0, maxLength => 60 }],
        ['tell', { %{ $list->('box', 'middle') }, default => ['box', 'middle'] }],
        ['among', { oneOf => [$word->('all'), { type => 'string', pattern => '^(attribute):.{1,40}$' }], default => 'all' }],
        ['pause', { oneOf => [{ type => 'number', minimum => 0, maximum => 60 }, $word->('none', 'blink')], default => 'none',
                'x-unit' => 's' }],
        ['axes', { oneOf => [$list->('x', 'y', 'z'), $word->('auto')], default => 'auto' }],
        ['nearby', { oneOf => [{ type => 'number', minimum => 0, maximum => 1e30 }, $word->('auto')], default => 'auto',
                'x-unit' => 'unit of the cloud' }],
        ['parts', { type => 'integer', minimum => 1, maximum => 100000, default => 4, 'x-unit' => 'steps' }],
    );
    is_deeply [keys %{ $census->{outputs} }], ['census'], 'its output';
    my $document = $census->{outputs}{census}{schema};
    is $document->{contentMediaType}, 'application/json', 'is a document';
    is_deeply [sort keys %{ $document->{properties} }], [sort 'box', keys %$counted], 'with these members';
    is_deeply [sort @{ $document->{required} }], [qw(counted near nearby parameters points seen)], 'of which those are always there';
    is_deeply $census->{'x-record'}{properties}{run_stage}{enum}, [qw(iterate polish baselines project insert copy prove tally reach forth back)],
        'a record may be of every stage';
    my $resample = json($daemon->get('/v1/processes/resample'))->{inputs};
    is_deeply $resample->{method}{schema}{enum}, ['cvt', 'kmeans', 'wlop', 'ear', 'toy'], 'resample has the method';
    ok exists $resample->{pause} && !exists $resample->{remark}, 'and its parameters';
    is_deeply json($daemon->get('/v1/processes/excerpt'))->{inputs}{method}{schema},
        { type => 'string', enum => ['toy'], default => 'toy' }, 'excerpt has no other';
    is_problem($daemon->get('/v1/processes/overlap'), 404, 'no-such-process', 'one of two clouds is not offered');
    is_problem($daemon->post('/v1/processes/overlap/execution', $plane), 404, 'no-such-process', 'nor run');
};

subtest 'a document is the answer' => sub {
    for my $path ('/v1/census', '/v1/processes/census/execution') {
        my $answer = $daemon->post("$path?$said", $plane);
        is $answer->{status}, 200, "POST $path answers";
        is $answer->{headers}{'content-type'}, 'application/json', 'with JSON';
        is_deeply json($answer), $counted, 'the document, with what was said';
        is $answer->{headers}{etag}, '"' . sha256_hex($answer->{content}) . '"', 'and its ETag';
        my ($id) = $answer->{headers}{location} =~ m{/v1/jobs/([^/]+)\z};
        is $daemon->get("/v1/jobs/$id/results/census")->{content}, $answer->{content}, 'which stays at results';
    }
    is $daemon->post("/v1/census?$said", $plane, Accept => $_)->{status}, 200, "Accept: $_"
        for 'application/json', '*/*', 'application/ply, application/json;q=0.1';
    is_problem($daemon->post("/v1/census?$said", $plane, Accept => 'application/ply'), 406, 'not-acceptable', 'it is no cloud');
};

subtest 'every kind is refused by name and range' => sub {
    my $takes = 'parts, pause, among, axes, nearby, strict, remark';
    my $lists = 'want each at most once and with commas between, words of';
    for my $case (
        ['strict=1', 'strict is "1", want true or false'], ['strict=', 'strict is empty, want true or false'],
        ['remark=' . 'x' x 61, 'remark is "' . 'x' x 61 . '", want text of 0 to 60 bytes'],
        ['remark=%ff', qr/^remark is "[^"]+", want text of 0 to 60 bytes$/],
        ['tell=box,box', qq(tell is "box,box", $lists box, middle, or none)],
        ['among=attribute:', 'among is "attribute:", want one of all or attribute:NAME of 1 to 40 bytes'],
        ['pause=61', 'pause is 61, want a number from 0 to 60 or one of none, blink'],
        ['axes=x,x', qq(axes is "x,x", $lists x, y, z, or none or auto)],
        ['nearby=-1', 'nearby is -1, want a number from 0 to 1e+30 or auto'],
        ['points=5', "no parameter points; census takes $takes, tell"],
        ['backward=true', "no parameter backward; census takes $takes, tell"],
        ['format=ply', "no parameter format; census takes $takes, tell"],
    ) {
        my ($query, $detail) = @$case;
        my $answer = $daemon->post("/v1/census?$query", $plane);
        is_problem($answer, 400, 'invalid-parameter', $query) or next;
        ref $detail ? like json($answer)->{detail}, $detail, $query : is json($answer)->{detail}, $detail, $query;
        is json($answer)->{errors}[0]{parameter}, (split /=/, $query)[0], 'errors[] names it';
    }
    for my $case (['axes=w', qq(axes is "w", $lists x, y, z, or none or auto)], ['tell=all', qq(tell is "all", $lists box, middle, or none)]) {
        my $unknown = $daemon->post("/v1/census?$case->[0]", $plane);
        is_problem($unknown, 422, 'unknown-word', $case->[0]) and is json($unknown)->{detail}, $case->[1], $case->[0];
    }
    my $answer = $daemon->post('/v1/resample?points=5&remark=x', $sphere);
    is_problem($answer, 400, 'invalid-parameter', 'resample takes no remark');
    like json($answer)->{detail}, qr/^no parameter remark; resample takes points, .*, normals, baselines, parts, pause$/, 'and says what it takes';
    $answer = $daemon->post('/v1/excerpt?points=5&polish=1', $sphere);
    like json($answer)->{detail}, qr/^no parameter polish; excerpt takes /, 'a group that a process leaves out';
    $answer = $daemon->post('/v1/excerpt?points=5&method=cvt', $sphere);
    is json($answer)->{detail}, 'method is "cvt", want one of toy', 'a method that it may not use';
};

subtest 'a job without a cloud among its outputs' => sub {
    my $id = submit('census?pause=0.15&parts=5', $plane);
    my @events = $daemon->events("/v1/jobs/$id/events", headers => $stream_of)->all;
    my @seen = progress(@events);
    is_deeply [grep { my $s = $_; !grep { $_->{run_stage} eq $s } @seen } qw(tally reach)], [], 'the stream has both stages';
    my %words = map { ("$_->{run_stage} $_->{step}/$_->{of}+$_->{ahead}" => 1) } @seen;
    is_deeply [grep { !/^(?:tally [0-5]\/5\+5|reach [0-5]\/5\+0)$/ } keys %words], [], 'with step, limit and what is ahead';
    ok never_falls(map { $_->{progress} } @seen), 'progress never falls';
    is $seen[-1]{progress}, 90, 'and reaches the end of the run';
    is_deeply [map { $_->{delta} } @seen], [map {undef} @seen], 'what is not known is null';
    is_deeply [sort grep { exists $seen[0]{$_} } qw(maxIterations maxPolish)], ['maxIterations', 'maxPolish'], 'members stay';
    is $seen[0]{maxIterations} + $seen[0]{maxPolish}, 0, 'and count nothing in a process that does not iterate';
    my @every = progress(every_event($id, 1));
    is_deeply [stages(@every)], [(map {"tally $_/5+5"} 0 .. 5), (map {"reach $_/5+0"} 0 .. 5)], 'a replay has every record';
    estimates_follow(@every);
    is_deeply [map { $_->{progress} } @every], [10, 18, 26, 34, 42, 50, 50, 58, 66, 74, 82, 90], 'progress goes by the steps of both';

    my $end = json($events[-1]{data});
    is $end->{status}, 'successful', 'it ends well';
    is $end->{href}, "$daemon->{url}/v1/jobs/$id/results/census", 'its end leads to the document';
    ok !exists $end->{report}, 'and to no report';
    my $info = json($daemon->get("/v1/jobs/$id"));
    is_deeply [@$info{qw(processID status progress)}], ['census', 'successful', 100], 'its statusInfo says so';
    is_deeply [map { $_->{title} } grep { $_->{rel} eq 'item' } @{ $info->{links} }], ['census'], 'and links to it';
    ok !exists $info->{voronoid}{target}, 'it has no target';
    is_deeply json($daemon->get("/v1/jobs/$id/results")), { census => { href => $end->{href}, type => 'application/json' } },
        'the results are the document';
    my $path = "/v1/jobs/$id/results/census";
    my $whole = $daemon->get($path);
    is json($whole)->{counted}, 25, 'the document is there';
    is $whole->{headers}{etag}, '"' . sha256_hex($whole->{content}) . '"', 'with its ETag';
    like $whole->{headers}{'content-disposition'}, qr/filename="\Q$id\E\.json"/, 'and a name';
    is +(grep { $_->{rel} eq 'item' } @{ $info->{links} })[0]{length}, length $whole->{content}, 'its length was told';
    is $daemon->get($path, headers => { 'If-None-Match' => $whole->{headers}{etag} })->{status}, 304, 'who has it is told so';
    is $daemon->get($path, headers => { Range => 'bytes=0-1' })->{content}, '{"', 'a part can be had';
    is_problem($daemon->get("/v1/jobs/$id/results/$_"), 404, 'no-such-output', "there is no $_") for qw(cloud report overlap);
    like json($daemon->get("/v1/jobs/$id/results/cloud"))->{detail}, qr/want census$/, 'it says what there is';
    my @rows = split /\n/, $daemon->get("/v1/jobs/$id/trace", headers => { Accept => 'text/csv' })->{content};
    like $rows[1], qr/^0,0,,,,,,0,[^,]+,tally,0,5,5,0,0,,,$/, 'the trace is a table of the same records';
    is scalar(@rows), 13, 'of all of them';
    is_deeply [map { $_->{jobID} } grep { $_->{jobID} eq $id } @{ json($daemon->get('/v1/jobs?processID=census'))->{jobs} }], [$id],
        'the list finds it by its process';
};

subtest 'a cloud by the method' => sub {
    my $id = submit('resample?points=300&method=toy&parts=5&pause=0.1', $sphere);
    my @seen = progress($daemon->events("/v1/jobs/$id/events", headers => $stream_of)->all);
    is_deeply [grep { my $s = $_; !grep { $_->{run_stage} eq $s } @seen } qw(copy prove)], [], 'the stream has its stages';
    ok never_falls(map { $_->{progress} } @seen), 'progress never falls';
    estimates_follow(progress(every_event($id, 1)));
    is $daemon->finish($id)->{status}, 'successful', 'it ends well';
    like json($daemon->get("/v1/jobs/$id"))->{message}, qr/^300 points after 5 copied parts and 5 proved parts, delta 0\.\d{4}$/,
        'and says after what';
    my $report = json($daemon->get("/v1/jobs/$id/results/report"));
    is_deeply [map { "$_->{stage} $_->{steps}" } @{ $report->{stages} }], ['copy 5', 'prove 5'], 'the report has the stages';
    is_deeply [@$report{qw(stopped iterations polish_steps)}], ['copied', 0, 0], 'and why it ended';
    is_deeply [@{ $report->{parameters} }{qw(method parts pause)}], ['toy', 5, 0.1], 'and what was asked';
    cmp_ok $report->{seconds}{iterate}, '>', 0.99, 'the time of its steps is among its seconds';
    my @copies = positions($daemon->get("/v1/jobs/$id/results/cloud")->{content});
    is scalar(@copies), 300, 'there are as many points as asked for';
    cmp_ok far_from(\@copies, [positions($sphere)]), '<', 1e-6, 'each one of the input';
    my $answer = $daemon->post('/v1/upsample?method=toy', $sphere);
    is_problem($answer, 422, 'target-out-of-range', 'it cannot give more');
    like json($answer)->{detail}, qr/^6000 points are asked for, want 1 to 1500: toy copies /, 'and says so';
};

subtest 'stopped and cancelled in the middle of a stage' => sub {
    my $id = submit('census?pause=0.2&parts=500', $plane);
    ok reaches($id, 'tally', 2), 'a census tallies';
    is $daemon->request('POST', "/v1/jobs/$id/stop")->{status}, 202, 'it can be stopped';
    is $daemon->finish($id)->{status}, 'successful', 'and ends well';
    my $document = json($daemon->get("/v1/jobs/$id/results/census"));
    cmp_ok $document->{seen}, '<', 25, 'with what it has seen';
    is $document->{counted}, $document->{seen}, 'and counted';

    $id = submit('resample?points=300&method=toy&pause=0.2&parts=500', $sphere);
    ok reaches($id, 'copy', 2), 'a run copies';
    $daemon->request('POST', "/v1/jobs/$id/stop");
    is $daemon->finish($id)->{status}, 'successful', 'stopped, it ends well';
    my $report = json($daemon->get("/v1/jobs/$id/results/report"));
    is_deeply [$report->{stopped}, $report->{points}{out}], ['stopped', 300], 'with every point';
    is_deeply [map { $_->{stage} } @{ $report->{stages} }], ['copy'], 'and without the second stage';

    for my $request ('census?pause=60', 'excerpt?points=300&pause=60') {
        $id = submit($request, $request =~ /^census/ ? $plane : $sphere);
        ok reaches($id, $request =~ /^census/ ? 'tally' : 'copy', 0), "$request runs";
        is json($daemon->request('DELETE', "/v1/jobs/$id"))->{status}, 'dismissed', 'it is dismissed at once';
        is_problem($daemon->get("/v1/jobs/$id/results/" . ($request =~ /^census/ ? 'census' : 'cloud')), 404,
            'result-not-available', 'and has no result');
    }
    is submit('census', $plane) && 1, 1, 'the next job has its place';
};

subtest 'a job that fails says why' => sub {
    my $answer = $daemon->post('/v1/census?among=attribute:no', $plane);
    is_problem($answer, 400, 'invalid-parameter', 'an attribute that the cloud does not have');
    is json($answer)->{detail}, 'among is attribute:no, want all or an attribute that the cloud has', 'it says so';
    is json($answer)->{errors}[0]{parameter}, 'among', 'errors[] names the parameter';
    my $id = submit('census?among=attribute:no', $plane);
    my $info = $daemon->finish($id);
    is $info->{status}, 'failed', 'asynchronously, too';
    is_problem($daemon->get("/v1/jobs/$id/results/census"), 400, 'invalid-parameter', 'in the place of its result');
};

# The request goes through the store as JSON; the input through a blob.
subtest 'the next daemon takes it up' => sub {
    my %asked = (%said, pause => 0.4, parts => 6);
    my $query = join '&', map {"$_=$asked{$_}"} sort keys %asked;
    my $census = submit("census?$query", $plane);
    my $excerpt = submit('excerpt?points=300&pause=0.4&parts=6', $sphere);
    ok reaches($census, 'tally', 1) && reaches($excerpt, 'copy', 1), 'two jobs run';
    $daemon->stop('KILL');
    $daemon = Vt->start(dir => $daemon->{dir}, jobs => 2);
    is $daemon->finish($census)->{status}, 'successful', 'after a crash the census ends well';
    is json($daemon->get("/v1/jobs/$census"))->{voronoid}{attempt}, 2, 'in its second attempt';
    is_deeply json($daemon->get("/v1/jobs/$census/results/census")),
        { %$counted, parameters => { %told, pause => 0.4, parts => 6 } }, 'of the same request';
    is_deeply [stages(progress(every_event($census, 2)))], [(map {"tally $_/6+6"} 0 .. 6), (map {"reach $_/6+0"} 0 .. 6)],
        'told from its beginning';
    is $daemon->finish($excerpt)->{status}, 'successful', 'so does the excerpt';
    is scalar(positions($daemon->get("/v1/jobs/$excerpt/results/cloud")->{content})), 300, 'with its points';

    my @kept = map { $daemon->get("/v1/jobs/$census$_")->{content} } '', '/results/census', '/trace';
    is $daemon->stop, 0, 'it goes down in good order';
    $daemon = Vt->start(dir => $daemon->{dir}, jobs => 2);
    my @again = map { $daemon->get("/v1/jobs/$census$_")->{content} } '', '/results/census', '/trace';
    s/127\.0\.0\.1:\d+/HOST/g for @kept, @again;
    is_deeply [map { JSON::PP->new->canonical->encode(json($_)) } @again], [map { JSON::PP->new->canonical->encode(json($_)) } @kept],
        'the next one has the job, its document and its records as they were';
    is scalar(grep { $_->{event} eq 'progress' } every_event($census, 2)), 14, 'and its events';
};

subtest 'the command line asks a daemon' => sub {
    my $folder = Cli::scratch();
    my $in = Cli::spew("$folder/plane.ply", $plane);
    my ($code, $here, $errors) = Cli::run(['census', $in, '--strict', '--tell=middle', '--nearby', 0.25, '--remark', 'a & b']);
    my @there = ('--server', $daemon->{url});
    my ($there_code, $there) = Cli::run(['census', $in, '--strict', '--tell=middle', '--nearby', 0.25, '--remark', 'a & b', @there]);
    is "$code$errors$there_code", '00', 'both go well';
    is_deeply json($there), json($here), 'the document is the same';
    (undef, my $lines) = Cli::run(['census', $in, '--pause', 0.15, '--json', '-o', "$folder/census.json", @there]);
    my @records = lines($lines);
    is_deeply [grep { !/^(?:tally|reach)$/ } map { $_->{run_stage} } @records], [], 'records come as they do here';
    is_deeply [sort keys %{ $records[0] }], [sort qw(iteration polish delta sigma epsilon energy max_move held seconds run_stage step of ahead best)],
        'with the same members';
    is_deeply [map { $_->{delta} } @records], [map {undef} @records], 'and nothing made up';
    ($code, undef, my $why) = Cli::run(['overlap', $in, '--other', $in, @there]);
    is "$code|$why", "2|voronoid: overlap: no option --server; see voronoid overlap --help\n", 'two clouds stay here';
};

is $daemon->stop, 0, 'the daemon ends with 0';
done_testing;
