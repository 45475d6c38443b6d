#!/usr/bin/perl
# The laws of ARCHITECTURE.md that can be read off the sources: who may include whom, one door to each library, no circle.
use strict;
use warnings;
use File::Temp;
use Test::More;

# The rooms of each part, lowest first. A file may include its own room and lower ones; rooms on one line do not see each
# other. A room is a folder, or a header with its source. The methods are seen by nobody but the engine.
my @core = ('base', 'cloud', 'spec', 'report', 'knn', 'geom', 'input', 'metrics', 'opt', 'seeds', 'mesh', 'method',
    'cvt kmeans lop remesh', 'align', 'output', 'baselines', 'process', 'engine', 'voronoid');
my %is_method = map { $_ => 1 } qw(cvt kmeans lop remesh);
my @server = ('base', 'proc', 'store blob', 'jobs', 'work', 'http', 'api', 'cli', 'serve', 'main');
# What proto and server see of core; the engine only where runs are made.
my %open = map { $_ => 1 } qw(base cloud spec report);
my %runs = map { $_ => 1 } qw(work cli);

my %door = (
    'microhttpd.h'  => qr{^server/http/},
    'cjson/cJSON.h' => qr{^proto/json/json_read\.c$},
    'cJSON.h'       => qr{^proto/json/json_read\.c$},
    'flann/flann.h' => qr{^(?:core/knn/knn_flann|server/base/flann_library)\.c$},
    'sqlite3.h'     => qr{^server/store/sqlite\.c$},
    'curl/curl.h'   => qr{^server/base/curl_library\.h$},
    'seccomp.h'     => qr{^server/proc/sandbox\.c$},
    'zlib.h'        => qr{^proto/gzip\.c$},
);
my @doors = (
    [qr{^draco/},  qr{^proto/draco/draco_shim\.cc$}],
    [qr{^nettle/}, qr{^server/base/digest\.c$}],
);

sub ranks {
    my %rank;
    for my $at (0 .. $#_) { $rank{$_} = $at for split ' ', $_[$at] }
    return %rank;
}
my %core_rank = ranks(@core);
my %server_rank = ranks(@server);

# The part and the room of a path: ("core", "geom").
sub room {
    my ($path) = @_;
    return ($1, $2) if $path =~ m{^(core|proto|server)/([^/.]+)};
    return ('', '');
}

# What is wrong with an include between two rooms of one part, or nothing.
sub fault_inside {
    my ($x, $y, %rank) = @_;
    return '' if $x eq $y;
    for ($x, $y) { return "$_ is not a room" unless exists $rank{$_} }
    return $rank{$y} >= $rank{$x} ? "$x sees $y" : '';
}

# What is wrong with one include, or nothing.
sub fault {
    my ($from, $to) = @_;
    if ($to =~ m{^(?:core|proto|server)/}) {
        my %part = (core => 0, proto => 1, server => 2);
        my ($a, $x) = room($from);
        my ($b, $y) = room($to);
        return "$a sees $b" if $part{$b} > $part{$a};
        if ($b eq 'core' && $a eq 'core') {
            return "$x sees the method $y" if $is_method{$y} && $x ne $y && $x ne 'engine';
            return fault_inside($x, $y, %core_rank);
        }
        if ($b eq 'core') {
            return '' if $open{$y} || ($a eq 'server' && $runs{$x} && ($y eq 'engine' || $y eq 'process'));
            return "$a/$x sees the inside of core";
        }
        return fault_inside($x, $y, %server_rank) if $a eq 'server' && $b eq 'server';
        return '';
    }
    return "$to has its one door elsewhere" if exists $door{$to} && $from !~ $door{$to};
    for (@doors) { return "$to has its one door elsewhere" if $to =~ $_->[0] && $from !~ $_->[1] }
    return '';
}

# Every unit (a header with its source) names others by including them or by calling what they define; the units of a
# circle, each list sorted, as tsort tells them: "tsort: FILE: input contains a loop:", then a line for each.
sub circles {
    my ($edges) = @_;
    my $pairs = File::Temp->new;
    for my $unit (sort keys %$edges) { print $pairs "$unit $_\n" for sort keys %{ $edges->{$unit} } }
    close $pairs;
    my (undef, @loops) = split /^.*: input contains a loop:\n/m, `LC_ALL=C tsort $pairs 2>&1 >/dev/null`;
    return map { join ' ', sort map { s/^tsort: //r } split /\n/ } @loops;
}

sub unit { return $_[0] =~ s/\.(?:[ch]|cc)$//r }

# Text without comments and string literals: names in them are no calls.
sub bare {
    my ($text) = @_;
    $text =~ s{/\*.*?\*/}{ }gs;
    $text =~ s{"(?:[^"\\]|\\.)*"}{""}g;
    return $text;
}

# The edges between the units of these files: path => text.
sub edges_of {
    my ($text) = @_;
    my (%home, %edges);
    for my $path (sort keys %$text) {
        next if $path =~ /\.h$/;
        # A function that this file defines: its name begins in a line that begins a definition.
        my $code = bare($text->{$path});
        while ($code =~ /^(?!static\b)[A-Za-z][\w \t*]*?\b(vor_\w+)\([^;{}]*\)\s*\{/mg) { $home{$1} = unit($path) }
    }
    for my $path (sort keys %$text) {
        my $from = unit($path);
        $edges{$from} //= {};
        while ($text->{$path} =~ /^\s*#\s*include\s*"([^"]+)"/mg) {
            $edges{$from}{ unit($1) } = 1 if exists $text->{$1} && unit($1) ne $from;
        }
        next if $path =~ /\.h$/;
        my $code = bare($text->{$path});
        while ($code =~ /\b(vor_\w+)\b/g) {
            $edges{$from}{ $home{$1} } = 1 if exists $home{$1} && $home{$1} ne $from;
        }
    }
    return \%edges;
}

my @files = grep { /\.(?:[ch]|cc)$/ && -f } split /\n/, `git ls-files -co --exclude-standard core proto server`;
cmp_ok(scalar @files, '>', 20, 'there are sources to look at');

my (@faults, %text);
for my $file (@files) {
    open my $in, '<', $file or next;
    local $/;
    $text{$file} = <$in>;
    close $in;
    my $line = 0;
    for (split /\n/, $text{$file}) {
        $line++;
        next unless /^\s*#\s*include\s*([<"])([^>"]+)[>"]/;
        my ($quote, $to) = ($1, $2);
        my $why = fault($file, $to);
        $why = 'not written from the root' if !$why && $quote eq '"' && $to !~ m{^build/} && !-f $to; # what is made may not be there yet
        push @faults, "$file:$line: $to: $why" if $why;
    }
}
is(join("\n", @faults), '', 'every include keeps the law');
is(join("\n", circles(edges_of(\%text))), '', 'no files go round in a circle');

# One planted violation of each kind is seen.
isnt(fault(@$_[0, 1]), '', "$_->[0] must not include $_->[1]") for (
    # upwards inside core; a method from elsewhere, and from another; no such room
    ['core/geom/cell.c', 'core/cvt/lloyd.h'], ['core/input/domain.c', 'core/seeds/seeds.h'], ['core/metrics/x.c', 'core/opt/anderson.h'],
    ['core/output/order.c', 'core/cvt/lloyd.h'], ['core/lop/project.c', 'core/cvt/lloyd.h'], ['core/kmeans/kmeans.c', 'core/cvt/cvt.h'],
    ['core/attic/x.c', 'core/base/run.h'],
    # the inside of core; between the parts
    ['proto/json/json.c', 'core/geom/cell.h'], ['server/api/app.c', 'core/engine.h'], ['proto/sse.c', 'server/http/http.h'],
    ['core/spec.c', 'proto/codec.h'],
    # upwards inside server; a second door
    ['server/store/store.h', 'server/jobs/job.h'], ['server/blob/dir.c', 'server/store/store.h'], ['server/http/http.c', 'server/api/app.h'],
    ['server/jobs/job.c', 'sqlite3.h'], ['server/api/app.c', 'microhttpd.h'], ['proto/codec.c', 'draco/compression/decode.h'],
);
is(fault(@$_), '', "$_->[0] may include $_->[1]") for (
    ['core/cvt/lloyd.c', 'core/seeds/seeds.h'], ['core/engine.c', 'core/cvt/cvt.h'], ['server/work/runner.c', 'core/engine.h'],
    ['proto/json/json.c', 'core/report.h'],
);
is(join('|', circles(edges_of({
    'core/a.h' => "#include \"core/b.h\"\n", 'core/b.h' => "#include \"core/c.h\"\n", 'core/c.h' => "#include \"core/a.h\"\n",
    'core/d.c' => "int x(void)\n{\n    return 0;\n}\n",
}))), 'core/a core/b core/c', 'a circle of includes is seen');
is(join('|', circles(edges_of({
    'server/p.c' => "int vor_p(void)\n{\n    return vor_q();\n}\n", 'server/q.c' => "int vor_q(void)\n{\n    return vor_p();\n}\n",
}))), 'server/p server/q', 'a circle of calls is seen');

my @cpp = grep { /\.cc$/ } @files;
is("@cpp", 'proto/draco/draco_shim.cc', 'there is one C++ file');
done_testing();
