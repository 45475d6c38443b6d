#!/usr/bin/perl
# Every process over HTTP: what its description says, what it does when nothing else is asked for, what a caller may
# change, and what it refuses.
use strict;
use warnings;
use FindBin;
use lib "$FindBin::Bin/../support";
use Test::More;
use Vt;

my $daemon = Vt->start;
my $brief = 'iterations=2&polish=0';
my $points = 600;
my $cloud = sphere_ply($points);

# The same with points that nothing near them points back to.
my $dirty = $cloud;
$dirty =~ s/element vertex \d+/'element vertex ' . ($points + 4)/e;
$dirty .= pack 'f<3', @$_ for [3, 3, 3], [-4, 2, 1], [0, 0, 5], [2, -5, 0];

sub vertices { return $_[0]{content} =~ /^element vertex (\d+)$/m ? $1 : -1 }

# A synchronous call that works: the answer, the job and its report.
sub done {
    my ($path, $body) = @_;
    my $answer = $daemon->post($path, $body // $cloud);
    my ($id) = ($answer->{headers}{location} // '') =~ m{/v1/jobs/([^/]+)$};

    is $answer->{status}, 200, "POST $path answers 200" or diag($answer->{content});
    return ($answer, map { json($daemon->get("/v1/jobs/$id$_")) } '', '/results/report');
}

# What each is asked here, what comes of it, and the same asked of resample.
my %as = (
    resample => { ask => 'points=200', out => 200, ratio => undef, outliers => 'keep', same => 'points=200' },
    denoise => { ask => '', out => $points, ratio => 1, outliers => 'drop', same => 'ratio=1&outliers=drop&filters=outliers,mls' },
    upsample => { ask => '', out => 4 * $points, ratio => 4, outliers => 'keep', same => 'ratio=4' },
    simplify => { ask => 'ratio=0.25', out => $points / 4, ratio => 0.25, outliers => 'keep', same => 'ratio=0.25' },
);
my @listed = @{ json($daemon->get('/v1/processes'))->{processes} };
is_deeply [map { $_->{id} } @listed], [qw(resample denoise upsample simplify measure inspect convert mesh restore register)], 'the list has every process';

for my $process (grep { $as{ $_->{id} } } @listed) {
    my ($id, $wanted) = ($process->{id}, $as{ $process->{id} });
    my ($self) = grep { $_->{rel} eq 'self' } @{ $process->{links} };
    my ($execute) = grep { $_->{rel} =~ m{/execute$} } @{ $process->{links} };
    is $self->{href}, "$daemon->{url}/v1/processes/$id", "$id: the list links to it";
    is $execute->{href}, "$daemon->{url}/v1/processes/$id/execution", "$id: and to its execution";
    my $described = json($daemon->get("/v1/processes/$id"));
    is_deeply [@$described{qw(id title description)}], [@$process{qw(id title description)}],
        "$id: the description is that of the list";

    my ($answer, $job, $report) = done("/v1/$id?$brief&$wanted->{ask}");
    is vertices($answer), $wanted->{out}, "$id: it gives $wanted->{out} points";
    is $job->{processID}, $id, "$id: the job bears its process";
    is $job->{voronoid}{target}{points}, $wanted->{out}, "$id: and its target";
    is_deeply $report->{points}, { in => $points, out => $wanted->{out} }, "$id: the report counts the points";
    my $parameters = $report->{parameters};
    is $parameters->{points}, $wanted->{out}, "$id: the points are resolved in the report";
    is $parameters->{ratio}, $wanted->{ratio}, "$id: so is the ratio";
    is $parameters->{outliers}, $wanted->{outliers}, "$id: and outliers";
    like $parameters->{neighbors}, qr/^\d+$/, "$id: and neighbors";
    for my $name (grep { $_ ne 'iterations' && $_ ne 'polish' } sort keys %{ $described->{inputs} }) {
        my $default = $described->{inputs}{$name}{schema}{default};
        next if !defined $default || $default eq 'auto';
        is_deeply $parameters->{$name}, $default, "$id: $name is at the default described";
    }
    is $daemon->post("/v1/processes/$id/execution?$brief&$wanted->{ask}", $cloud)->{content}, $answer->{content},
        "$id: its execution gives the same bytes";
    is $daemon->post("/v1/resample?$brief&$wanted->{same}", $cloud)->{content}, $answer->{content},
        "$id: so does resample when asked for what the preset says";
    is $daemon->get("/v1/$id")->{headers}{allow}, 'POST, OPTIONS', "$id: it is posted to";
}

# Forms are made of the descriptions: titles, levels, groups and presets, whose values are taken as they are.
my $many = sphere_ply(700); # of which there may be 16 times as many
my %names;
for my $process (@listed) {
    my $described = json($daemon->get("/v1/processes/$process->{id}"));
    my %parameters = map { $_ => $described->{inputs}{$_} } grep { $described->{inputs}{$_}{'x-level'} } keys %{ $described->{inputs} };
    is_deeply [grep { !$parameters{$_} } sort keys %{ $described->{inputs} }], [grep { /^(?:cloud|reference|previous)$/ } sort keys %{ $described->{inputs} }],
        "$process->{id}: every parameter has a level";
    is_deeply [grep { $parameters{$_}{'x-level'} !~ /^(?:basic|advanced)$/ || $parameters{$_}{title} eq $_ || !$parameters{$_}{'x-group'} }
        sort keys %parameters], [], 'one of the two, a title and a group';
    is_deeply [grep { my ($on) = %{ $parameters{$_}{'x-when'} }; !$parameters{$on} } grep { $parameters{$_}{'x-when'} } sort keys %parameters], [],
        'what a parameter hangs on is one of the process';
    for my $preset (@{ $described->{'x-presets'} }) {
        $names{$preset->{name}} = $process->{id};
        my %values = (%{ $preset->{values} }, $parameters{polish} ? (iterations => 0, polish => 0) : ());
        my $answer = $daemon->post("/v1/$process->{id}?" . join('&', map { "$_=" . (ref $values{$_} ? join ',', @{ $values{$_} } : $values{$_}) } sort keys %values), $many);
        is $answer->{status}, 200, "$process->{id}: the preset $preset->{name} can be asked for" or diag $answer->{content};
    }
}
is_deeply \%names, { even => 'resample', edges => 'resample', denoise => 'denoise', decoded => 'restore', fourfold => 'upsample', quarter => 'simplify',
    mesh => 'mesh' }, 'the presets that there are';
is_deeply json($daemon->get('/v1/processes/resample'))->{inputs}{sigmaP}{'x-when'}, { method => ['wlop', 'ear'] }, 'a parameter of two methods says so';
my ($first) = grep { $_->{name} eq 'even' } @{ json($daemon->get('/v1/processes/resample'))->{'x-presets'} };
is_deeply $first->{values}, { points => 10000 }, 'numbers are numbers';
is json($daemon->get('/v1/processes/upsample'))->{'x-presets'}[0]{title}, "\x{d7}4 points", 'titles are UTF-8';

# The caller wins.
for my $case (
    ['denoise?points=50', 50], ['denoise?ratio=0.5', 300], ['denoise?ratio=2', 1200], ['upsample?points=700', 700],
    ['upsample?ratio=1', 600], ['upsample?points=9600', 9600], ['simplify?points=600', 600], ['simplify?ratio=1', 600],
) {
    my ($query, $wanted) = @$case;
    is vertices($daemon->post("/v1/$query&iterations=0&polish=0", $cloud)), $wanted, "$query: as many as asked for";
}
my (undef, undef, $even) = done("/v1/upsample?spacing=0.1&$brief");
cmp_ok abs($even->{points}{out} - 1451), '<', 80, 'spacing says how many points an upsampled cloud has';
ok !exists $even->{parameters}{ratio}, 'and the ratio of the preset is not among its parameters';

my (undef, undef, $dropped) = done("/v1/denoise?$brief", $dirty);
cmp_ok $dropped->{outliers}, '>=', 4, 'denoise leaves outliers out';
is $dropped->{points}{out}, $points + 4, 'and gives as many points as the input has';
my (undef, undef, $kept) = done("/v1/denoise?$brief&outliers=keep", $dirty);
is $kept->{outliers}, 0, 'but for a caller who wants them kept';
is $kept->{parameters}{outliers}, 'keep', 'as the report says';

# All of them spread points in planes when told so.
for my $id (sort keys %as) {
    my $ask = join '&', $brief, grep { $_ } $as{$id}{ask};
    my ($flat, undef, $report) = done("/v1/$id?$ask&patch=plane");
    is $report->{parameters}{patch}, 'plane', "$id: patches are planes";
    is vertices($flat), $as{$id}{out}, "$id: as many points come of it";
    isnt $flat->{content}, $daemon->post("/v1/$id?$ask", $cloud)->{content}, "$id: in other places";
}

# Means are of input points, so that they cannot be more than those.
for my $id (grep { $_ ne 'upsample' } sort keys %as) {
    my (undef, undef, $report) = done("/v1/$id?points=150&method=kmeans&iterations=3");
    is_deeply [map { $_->{steps} } @{ $report->{stages} }], [3], "$id: kmeans makes 3 steps of one stage";
    cmp_ok abs($report->{area} - 12.566), '<', 0.5, "$id: the area is that of the sphere";
}
like json($daemon->post('/v1/upsample?method=kmeans', $cloud))->{detail}, qr/^method is "kmeans", want one of cvt, wlop, ear, isotropic, insert$/,
    'upsample has no means of so many points';
# method=insert keeps the points of the input: first, in their order, bit for bit, also those in one place.
my @places = unpack '(a12)*', $cloud =~ s/\A.*?end_header\n//sr;
$places[1] = $places[0];
for my $type (['float', 'f<3V', 0], ['double', 'd<3V', 1e5 / 3]) {
    my ($name, $row, $far) = @$type;
    my $rows = join '', map { pack $row, (map { $_ + $far } unpack 'f<3', $places[$_]), $_ } 0 .. $points - 1;
    my $head = join '', "ply\nformat binary_little_endian 1.0\nelement vertex $points\n", map("property $name $_\n", qw(x y z)), "property uint label\nend_header\n";
    for my $n ($points, $points + 1, 4 * $points) {
        my ($answer, undef, $report) = done("/v1/upsample?method=insert&points=$n", $head . $rows);
        my @out = unpack '(a' . length($rows) / $points . ')*', $answer->{content} =~ s/\A.*?end_header\n//sr;
        is join('', @out[0 .. $points - 1]), $rows, "$name, $n points: the input's are the first";
        my (%at, %label);
        for (@out) { my @is = unpack $row, $_; $at{"@is[0 .. 2]"}++; $label{ $is[3] }++ }
        is scalar @out, $n, "$name, $n points: as many as asked for";
        cmp_ok abs($report->{area} - 12.566), '<', 0.5, "$name, $n points: on a surface of the right area";
        is scalar keys %at, $n - 1, "$name, $n points: new ones have places of their own";
        cmp_ok +(sort { $b <=> $a } values %label)[0], '<=', 2 * $n / $points, "$name, $n points: they have labels near them";
    }
}
is json($daemon->post('/v1/upsample?method=insert&points=599', $cloud))->{type} =~ s{.*/}{}r, 'target-out-of-range', 'none of them is dropped';
for my $asked ('filters=mls', 'boundary=fill', 'order=progressive', 'lattice=keep', 'sample=faces', 'density=curvature') {
    like json($daemon->post("/v1/upsample?method=insert&$asked", $cloud))->{detail}, qr/^$asked does not work with method=insert: use /, "nor $asked";
}
like json($daemon->post('/v1/resample?points=700&method=insert', $cloud))->{detail}, qr/^method is "insert", want one of/, 'only upsample inserts';
my $too_many = $daemon->post('/v1/resample?points=700&method=kmeans', $cloud);
like "$too_many->{status} " . json($too_many)->{detail}, qr/^422 700 points are requested, want 1 to $points: method=kmeans cannot give more/, 'nor has resample, as it says';

# A process of two clouds describes both; its parameter is foreign to the others.
my $measure = json($daemon->get('/v1/processes/measure'));
is_deeply [sort keys %{ $measure->{inputs} }], [qw(cloud invalid peak reference)], 'measure takes a cloud, a reference and a peak';
is $measure->{inputs}{reference}{minOccurs}, 0, 'of which the reference need not come';
is json($daemon->post('/v1/processes/measure/execution', $cloud))->{n}, $points, 'a body alone is its cloud';
ok !exists json($daemon->get("/v1/processes/$_"))->{inputs}{peak}, "$_ does not describe peak" for sort keys %as;
my $names = qr/nearest: (?:\w+, ){2}\w+/;

# Refusals that the head decides, and those that the cloud does: both ways to run a process.
for my $case (
    ['upsample', 'ratio=0.5', 400, qr/^ratio is 0\.5, want a number from 1 to 16$/, 'ratio'],
    ['upsample', 'ratio=17', 400, qr/^ratio is 17, want a number from 1 to 16$/, 'ratio'],
    ['upsample', 'points=600&ratio=2', 400, qr/points, ratio and spacing, not 2/, 'points'],
    ['simplify', 'ratio=1.5', 400, qr/^ratio is 1\.5, want a number from 1e-06 to 1$/, 'ratio'],
    ['simplify', '', 400, qr/^give exactly one of the parameters points, ratio and spacing: none is given$/, 'points'],
    ['simplify', 'outliers=drop', 400, qr/^give exactly one of the parameters points, ratio and spacing: none/, 'points'],
    ['resample', '', 400, qr/^give exactly one of the parameters points, ratio and spacing: none/, 'points'],
    ['denoise', 'ratio=16.5', 400, qr/^ratio is 16\.5, want a number from 1e-06 to 16$/, 'ratio'],
    ['denoise', 'pionts=5', 400, qr/^unknown parameter "pionts" of denoise; $names$/, 'pionts'],
    ['simplify', 'points=5&peak=1', 400, qr/^unknown parameter "peak" of simplify; $names$/, 'peak'],
    ['resample', 'points=5&p%c3%a9q=1', 400, qr/^unknown parameter "p\\xc3\\xa9q" of resample; $names$/, 'p\\xc3\\xa9q'],
    ['upsample', 'points=599', 422, qr/^points is 599, want 600 to 9600: the result of upsample may have 1 to 16 times as many points as the input \(600\)$/],
    ['upsample', 'points=9601', 422, qr/^points is 9601, want 600 to 9600: /],
    ['upsample', 'spacing=0.5', 422, qr/^spacing is 0\.5 and needs \d\d points, want 600 to 9600: the result of upsample /],
    ['simplify', 'points=601', 422, qr/^points is 601, want 1 to 600: simplify cannot give more points than the input has \(600\)$/],
    ['simplify', 'spacing=0.1', 422, qr/^spacing is 0\.1 and needs 1\d\d\d points, want 1 to 600: simplify /],
    ['denoise', 'points=9601', 422, qr/^points is 9601, want 1 to 9600: the result of denoise may have up to 16 times as many points/],
    ['resample', 'points=9601', 422, qr/^points is 9601, want 1 to 9600: the result of resample may have up to 16 times as many points/],
) {
    my ($id, $query, $status, $detail, $parameter) = @$case;
    for my $path ("/v1/$id", "/v1/processes/$id/execution") {
        my $answer = $daemon->post("$path?$query", $cloud);
        is_problem($answer, $status, $status == 400 ? 'invalid-parameter' : 'target-out-of-range', "$path?$query")
            or next;
        like json($answer)->{detail}, $detail, "$path?$query: it names value and range";
        is json($answer)->{errors}[0]{parameter}, $parameter, "$path?$query: errors[] names the parameter"
            if $parameter;
    }
}
my $before = @{ json($daemon->get('/v1/jobs?limit=1000'))->{jobs} };
is $daemon->post("/v1/$_", $cloud, Prefer => 'respond-async')->{status}, 422, "$_ is refused before there is a job"
    for 'simplify?points=601', 'upsample?points=599', 'denoise?ratio=0.0001';
is scalar(@{ json($daemon->get('/v1/jobs?limit=1000'))->{jobs} }), $before, 'and leaves none behind';

# Jobs of one process, in the list and as a stream.
my $accepted = $daemon->post("/v1/simplify?points=100&$brief", $cloud, Prefer => 'respond-async');
is $accepted->{status}, 201, 'a job can be accepted';
is json($accepted)->{processID}, 'simplify', 'it bears its process from the beginning';
is $daemon->finish(json($accepted)->{jobID})->{processID}, 'simplify', 'to the end';
my @found = @{ json($daemon->get('/v1/jobs?limit=1000&processID=simplify'))->{jobs} };
is json($accepted)->{jobID}, $found[0]{jobID}, 'the list finds it by its process';
is_deeply [grep { $_->{processID} ne 'simplify' } @found], [], 'and no other';
my @events = $daemon->events("/v1/upsample?$brief", method => 'POST', body => $cloud,
    headers => { Accept => 'text/event-stream' })->all;
is json($events[0]{data})->{processID}, 'upsample', 'a stream tells the process';
is json($events[-1]{data})->{status}, 'successful', 'and ends well';
is $daemon->stop, 0, 'the daemon ends with 0';
done_testing;
